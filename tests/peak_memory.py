"""Predicted and measured peak of the memory of the first steps of a library scene, on Linux.

    python peak_memory.py SCENE DX      -> JSON: predicted, measured [bytes]
"""

import json
import sys
import tempfile
from pathlib import Path

import snowmpm
from snowmpm.build import build
from snowmpm.description import describe
from snowmpm.scenes import load_scene

scene = load_scene(sys.argv[1], {"solver.dx": float(sys.argv[2])} if float(sys.argv[2]) else {})
model = build(scene)
described = describe(model, model.solver())
del model
# Two frames, some steps, two checkpoints: later ones take no more
short = load_scene(scene.source, {"solver.dx": scene.solver.dx, "end_time": 10 * described["dt"],
                                  "output.interval": 5 * described["dt"]})
short = short.model_copy(update={"initial": short.initial.model_copy(update={"tolerance": 1e3})})
with tempfile.TemporaryDirectory() as folder:
    snowmpm.run(short, folder)
status = Path("/proc/self/status").read_text().splitlines()
peak = next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM:"))
print(json.dumps({"predicted": described["memory"], "measured": peak}))

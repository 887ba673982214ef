"""Predicted and measured peak of the memory of the first steps of a scene, on Linux.

    python peak_memory.py SCENE [--slow-disk] KEY=VALUE ...      -> JSON: predicted, measured [bytes]

--slow-disk: every frame takes so long to write that as many wait for it as there is room for.
"""

import json
import multiprocessing
import sys
import tempfile
import time
from pathlib import Path

from snowmpm.cli.options import setting_values
from snowmpm.io import RunWriter
from snowmpm.running import loop
from snowmpm.running.description import describe
from snowmpm.scenes import load_scene
from snowmpm.setup.build import build


def describe_in_a_child(name, settings, answer):
    model = build(load_scene(name, settings))
    answer.put(describe(model, model.solver()))


def slow_down():
    write = RunWriter.frame

    def slow_write(self, *frame):
        time.sleep(5.0)
        write(self, *frame)

    RunWriter.frame = slow_write


def first_steps(name, settings, described):
    """Two frames, some steps, two checkpoints: later ones take no more; -> peak [bytes]."""
    scene = load_scene(name, {**settings, "end_time": 10 * described["dt"], "output.interval": 5 * described["dt"]})
    scene = scene.model_copy(update={"initial": scene.initial.model_copy(update={"tolerance": 1e3})})
    with tempfile.TemporaryDirectory() as folder:
        loop.run(scene, folder)
    status = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM:"))


if __name__ == "__main__":
    name, *rest = sys.argv[1:]
    settings = setting_values(text for text in rest if text != "--slow-disk")
    # In a process of its own, or its memory would be measured, too
    context = multiprocessing.get_context("fork")
    answer = context.Queue()
    child = context.Process(target=describe_in_a_child, args=(name, settings, answer))
    child.start()
    described = answer.get(timeout=1200)
    child.join()
    if "--slow-disk" in rest:
        slow_down()
    print(json.dumps({"predicted": described["memory"], "measured": first_steps(name, settings, described),
                      "particles": sum((described.get("particles") or described["columns"]).values())}))

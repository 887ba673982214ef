"""Programs around snowmpm: each in a process of its own, within a time limit, on a small block that falls."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
LIMIT = 600
"""[s] that no program may take; what hangs took for ever."""

BEGINNING = """
import faulthandler, gc, hashlib, os, sys, threading, warnings

import numpy as np
import taichi as ti
import snowmpm
from snowmpm.errors import EndedError

def block(precision="f32"):
    return snowmpm.Simulation(snowmpm.load_scene(BLOCK, {"solver.precision": precision}))

def go_on(simulation, steps=20):
    for _ in range(steps):
        simulation.step()
    return digest(simulation)

def digest(simulation):
    fields = simulation.particles
    return hashlib.sha256(b"".join(fields[name].tobytes() for name in ("position", "velocity", "stress"))).hexdigest()

def in_parallel(n=60000):
    "A loop that Taichi hands to its threads."
    from snowmpm.materials import Elastic, StressUpdate
    snowmpm.start()
    update = StressUpdate(Elastic(density=300.0, youngs_modulus=1e5, poisson_ratio=0.2), 2)
    return float(update(np.zeros((n, 4)), update.initial_state(n), np.full((n, 2, 2), 1e-3)).stress.sum())
"""


@pytest.fixture
def program(tmp_path):
    """program(text, code=0) -> what a program printed that begins with `BEGINNING` and ends with this exit code."""

    def run(text, code=0):
        file = tmp_path / "program.py"
        file.write_text(BEGINNING.replace("BLOCK", repr(str(TESTS / "cli" / "block.toml"))) + text)
        paths = os.pathsep.join([str(TESTS.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
        # Unbuffered, Python writes a line and its end apart, and processes that share the pipe write between them
        around = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
        done = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, timeout=LIMIT,
                              env={**around, "PYTHONPATH": paths}, cwd=tmp_path)
        assert done.returncode == code, done.stdout + done.stderr
        return [line for line in done.stdout.splitlines() if not line.startswith("[Taichi]")]

    return run


@pytest.fixture(scope="session")
def expected():
    """What `go_on(block(precision))` gives, by precision, in this process."""
    names = {}
    exec(BEGINNING.replace("BLOCK", repr(str(TESTS / "cli" / "block.toml"))), names)
    return {precision: names["go_on"](names["block"](precision)) for precision in ("f32", "f64")}

"""Gravity over time, fields and damping through a checkpoint, and with one thread and two: the same to the bit."""

import hashlib
import json
import subprocess
import sys

import numpy as np
import pytest

from snowmpm.compiler import runtime
from snowmpm.io import checkpoint
from tests.forcing.stage import METHODS, run, stage

FORCES = [{"kind": "acceleration", "value": ["sin(40*t) - 0.1*vx", 0.0], "within": {"min": [0, 0], "max": [0.3, 9]}},
          {"kind": "pressure", "value": "2000*step(0, 0.02, t)*(1 + 0.1*x)"},
          {"kind": "pressure", "acts_on": "pores", "value": "-500*z"}]


def shaken(method, dim=2):
    """`Simulation` with all kinds of forces."""
    lower, upper = [0.0] * dim, [0.4] * dim
    return stage(method, precision="f32", shape={"kind": "box", "min": lower, "max": upper}, forces=[
        {**force, **({"value": ["sin(40*t) - 0.1*vx", "0.3*vy", 0.0], "within": {"min": [0, 0, 0], "max": [0.3, 9, 9]}}
                     if dim == 3 and "within" in force else {})} for force in FORCES],
        gravity={"times": [0.0, 0.02], "values": [0.0, 9.81], "tilts": [0.0, 20.0]},
        damping={"coefficient": 3.0, "start": 0.005, "rest_speed": 1e-3})


def digest(simulation):
    """Of the particles, and of what the audit says."""
    state = simulation.solver.state()
    numbers = [state["reals"], state["labels"], state["loaded"], state["weight_impulse"]]
    text = hashlib.sha256(b"".join(np.ascontiguousarray(part).tobytes() for part in numbers)).hexdigest()
    return text, simulation.audit()


@pytest.mark.parametrize("method", METHODS)
def test_resumed_run_is_the_same_to_the_bit(method, tmp_path):
    whole, first = shaken(method), shaken(method)
    run(whole, 0.01)
    run(first, 0.01)
    checkpoint.save(first, tmp_path / "checkpoint.npz")
    second = shaken(method)
    checkpoint.restore(second, tmp_path / "checkpoint.npz")
    run(whole, 0.02)
    run(second, 0.02)
    assert digest(second) == digest(whole)
    row = whole.audit()
    assert min(abs(row[name]) for name in ("force_work", "damping_work", "potential_energy")) > 0.0


@pytest.mark.slow
def test_one_and_two_threads_agree():
    outcomes = [json.loads(subprocess.run([sys.executable, "-m", "tests.forcing.test_resumed", threads], check=True,
                                          capture_output=True, text=True).stdout.splitlines()[-1]) for threads in "12"]
    assert len(outcomes[0]) == 4 and outcomes[0] == outcomes[1]


def main(threads):
    """Every case, as JSON."""
    runtime.start("cpu", threads)
    found = []
    for method in METHODS:
        for dim in (2, 3):
            simulation = shaken(method, dim)
            run(simulation, 0.01)
            found.append([*digest(simulation)])
    print(json.dumps(found))


if __name__ == "__main__":
    main(int(sys.argv[1]))

"""No kernel reads or writes beyond an array: Taichi's own check of every index, in a process of its own.

A read beyond an array is harmless for years, where its value is not used, and then ends a run where the next page of
memory is nobody's.
"""

import os
import subprocess
import sys

import pytest

SCENE = """
from snowmpm import Simulation, load_scene
sim = Simulation(load_scene({name!r}, {changes}))
for _ in range({steps}):
    sim.step()
sim.audit()
"""
TURNED = """
import numpy as np
from snowmpm import start
from snowmpm.study.problems.schemes import APIC
from snowmpm.study.problems.self_weight_column import SNOW, column
start("cpu")
solver = column(SNOW, 10.0, APIC, 0.0, np.pi / 6, width=12)[0]
for _ in range(3):
    solver.step(solver.stable_dt()[0])
"""


def run_checked(program):
    done = subprocess.run([sys.executable, "-c", program], env={**os.environ, "TI_DEBUG": "1"}, capture_output=True,
                          text=True, timeout=600)
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.slow
def test_the_check_itself():
    """What it is for does not pass."""
    with pytest.raises(AssertionError, match="Out of bound access"):
        run_checked("""
import taichi as ti
from snowmpm import start
from tests.support.past_the_end import past_the_end
start("cpu")
past_the_end(ti.ndarray(ti.i32, (4,)))
""")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "changes"), [
    ("slab_release_2d", {"solver.dx": 0.2}), ("pst_2d", {"solver.dx": 0.02}), ("impact_mast", {"solver.dx": 0.5}),
    ("impact_wedge_2d", {"solver.kernel": "cubic", "solver.transfer": "flip"}), ("natural_release", {}),
    ("microstructure_2d", {}), ("column_collapse_3d", {"solver.method": "sph", "solver.dx": 0.04}),
    ("flume_impact", {"solver.method": "sph", "solver.dx": 0.04})])
def test_scenes(name, changes):
    run_checked(SCENE.format(name=name, changes=changes, steps=12))


@pytest.mark.slow
def test_walls_oblique_to_the_grid():
    run_checked(TURNED)

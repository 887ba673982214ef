"""The memory that `snowmpm check` predicts is what a run takes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from snowmpm.errors import InputError
from snowmpm.scenes import Scene, library
from snowmpm.setup.build import build

BY_SPH = ("avalanche_on_raster", "column_collapse_2d", "column_collapse_3d", "elastic_beam", "flume_impact",
          "impact_wall_2d", "oedometer", "sand_between_plates", "slab_release_2d", "slope_failure")

CASES = [*([scene] for scene in sorted(library())), *([scene, "solver.method=sph"] for scene in BY_SPH),
         ["slab_release_resolved", "--slow-disk"]]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak is asked of Linux")
@pytest.mark.parametrize("case", CASES, ids=" ".join)
def test_peak_memory(case):
    """Within 15 % of what a process takes in its first steps, of every library scene as it is. Of a second process, if
    need be: the first may have compiled its kernels, which takes memory once on a machine."""
    script = Path(__file__).with_name("peak_memory.py")
    for _ in range(2):
        done = subprocess.run([sys.executable, script, *case], capture_output=True, text=True, check=True)
        found = json.loads(done.stdout.splitlines()[-1])
        if found["predicted"] == pytest.approx(found["measured"], rel=0.15):
            break
    print(f"{' '.join(case)}: {found['predicted'] / 2**20:.0f} MiB predicted, {found['measured'] / 2**20:.0f} MiB")
    assert found["predicted"] == pytest.approx(found["measured"], rel=0.15)


def test_maps_over_a_domain_far_larger_than_the_snow_are_refused():
    """Before anything is allocated; `check` says how much it would be."""
    snow = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}
    made = Scene.model_validate({
        "name": "p", "dimension": 3, "end_time": 0.02, "output": {"interval": 0.01}, "solver": {"dx": 0.01},
        "domain": {"min": [0.0, 0.0, 0.0], "max": [5000.0, 5000.0, 500.0], "boundary": "slip"},
        "materials": {"snow": snow}, "bodies": [{"name": "b", "material": "snow", "shape": {
            "kind": "box", "min": [0.0, 0.0, 0.0], "max": [0.1, 0.1, 0.1]}}]})
    with pytest.raises(InputError, match=r"output.map_cell: maps of .* needs about .* of memory"):
        build(made).map_grid  # noqa: B018
    small = made.model_copy(update={"domain": made.domain.model_copy(update={"max": (1.0, 1.0, 1.0)})})
    assert 0.0 < build(small).map_grid.memory < 1e7

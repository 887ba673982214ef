"""The memory that `snowmpm check` predicts is what a run takes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from snowmpm.scenes import library

BY_SPH = ("avalanche_on_raster", "column_collapse_2d", "column_collapse_3d", "elastic_beam", "flume_impact",
          "impact_wall_2d", "oedometer", "sand_between_plates", "slab_release_2d", "slope_failure")

CASES = [*([scene] for scene in sorted(library())), *([scene, "solver.method=sph"] for scene in BY_SPH),
         ["slab_release_resolved", "--slow-disk"]]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak is asked of Linux")
@pytest.mark.parametrize("case", CASES, ids=" ".join)
def test_peak_memory(case):
    """Within 15 % of what a process takes in its first steps, of every library scene as it is."""
    script = Path(__file__).with_name("peak_memory.py")
    done = subprocess.run([sys.executable, script, *case], capture_output=True, text=True, check=True)
    found = json.loads(done.stdout.splitlines()[-1])
    print(f"{' '.join(case)}: {found['predicted'] / 2**20:.0f} MiB predicted, {found['measured'] / 2**20:.0f} MiB")
    assert found["predicted"] == pytest.approx(found["measured"], rel=0.15)

"""The memory that `snowmpm check` predicts is what a run takes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from snowmpm.scenes import library

COARSER = {"avalanche_on_raster": 3.0, "impact_mast": 0.3, "microstructure": 1e-4, "natural_release": 0.1, "pst": 0.05,
           "skier_trigger": 0.1, "slab_release": 0.4}
"""dx [m] of scenes of which some steps would take minutes; the others are taken as they are."""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak is asked of Linux")
@pytest.mark.parametrize("scene", sorted(library()))
def test_peak_memory(scene):
    script = Path(__file__).with_name("peak_memory.py")
    done = subprocess.run([sys.executable, script, scene, str(COARSER.get(scene, 0.0))], capture_output=True, text=True,
                          check=True)
    found = json.loads(done.stdout.splitlines()[-1])
    print(f"{scene}: {found['predicted'] / 2**20:.0f} MiB predicted, {found['measured'] / 2**20:.0f} MiB measured")
    assert found["predicted"] == pytest.approx(found["measured"], rel=0.15)

"""Runs that earlier versions wrote."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from snowmpm.io import Run


def test_a_run_of_0_1_0_still_opens(tmp_path, call):
    """A depth-averaged run on a plane with a post, as version 0.1.0 wrote it: its numbers, `info`, `maps`, `plot`."""
    path = tmp_path / "old" / "run.vtkhdf"
    path.parent.mkdir()
    path.write_bytes(gzip.decompress((Path(__file__).parent / "run_of_0_1_0.vtkhdf.gz").read_bytes()))
    run = Run(path)
    assert run.provenance["version"] == "0.1.0" and run.complete
    assert run.times.tolist() == [0.0, 4.0, 8.0] and len(run.frame(-1).points) == run.provenance["particles"]
    assert run.history["mass"][-1] == pytest.approx(run.history["mass"][0])
    assert run.frame(-1).fields["velocity"].max() > 5.0 and "post" in run.obstacles
    assert np.nanmax(run.maps["peak_depth"].values) > 0.3
    assert call("info", path.parent).code == 0
    assert call("maps", path.parent, "-o", tmp_path / "maps").code == 0
    assert (tmp_path / "maps" / "peak_depth.tif").exists()
    assert call("plot", path.parent, "-o", tmp_path / "old.png").code == 0

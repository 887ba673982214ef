"""A dam across the path of the library's avalanche: the run-out point stays in the deposit and comes no further."""

import pytest

import snowmpm
from snowmpm.scenes import load_scene

CELL = 10.0
DAMS = {"gully": [[600358.0, 200185.0], [600358.0, 200305.0]], "mouth": [[600507.0, 200162.0], [600529.0, 200321.0]],
        "apron": [[600605.0, 200128.0], [600629.0, 200327.0]]}
"""Lines across the valley [m], 250, 400 and 500 m down the path; the free run-out is 578 m."""


def avalanche(folder, **changes):
    return snowmpm.run(load_scene("avalanche_depth_averaged", {"solver.dx": CELL, **changes}), folder)


@pytest.fixture(scope="module")
def free(tmp_path_factory):
    return avalanche(tmp_path_factory.mktemp("free") / "run")


@pytest.mark.parametrize("place", DAMS)
def test_a_dam_across_the_path_never_lengthens_the_run_out(free, tmp_path, place):
    dam = {"name": "dam", "line": DAMS[place], "height": 10.0, "crest_width": 5.0}
    dammed = avalanche(tmp_path / "run", **{"terrain.dams": [dam]})
    numbers, before = dammed.hazard["numbers"], free.hazard["numbers"]
    assert numbers["runout"] <= before["runout"] + CELL
    assert numbers["deposit_reach"] <= before["deposit_reach"] + CELL
    assert numbers["thalweg_dry"] < 0.05
    assert deposit_at(dammed, numbers["runout_x"], numbers["runout_y"]) >= numbers["flow_depth"]


def deposit_at(run, x, y):
    """Depth of the deposit [m] in the map cell that holds a place."""
    raster = run.maps["deposit_depth"]
    i, j = (round((place - corner - middle) / raster.cell) for place, corner, middle
            in ((x, run.origin[0], raster.x0), (y, run.origin[1], raster.y0)))
    return raster.values[j, i]

"""Dams on an elevation raster, and flows that meet them."""

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.scenes.dams import Dam
from snowmpm.scenes.schema import Scene
from snowmpm.terrain.dams import with_dams
from snowmpm.terrain.raster import Raster


def plane(slope=0.0, n=41, cell=1.0):
    x = cell * np.arange(n, dtype=float)
    return Raster(x, x, np.broadcast_to(-slope * x, (n, n)).copy())


def test_a_dam_has_the_height_and_the_slopes_that_it_is_given():
    dam = Dam(name="wall", line=[[20.0, 5.0], [20.0, 35.0]], height=6.0, crest_width=2.0)  # its usual slope, 45 degrees
    z = with_dams(plane(), [dam]).z
    across = z[20]
    assert across[20] == across[21] == across[19] == pytest.approx(6.0)  # the crest is 2 m wide
    assert across[22] == pytest.approx(5.0)
    assert across[26] == pytest.approx(1.0)
    assert across[28] == 0.0
    assert z[5, 20] == pytest.approx(6.0)
    assert z[2, 20] == pytest.approx(4.0)  # round its end
    assert z[39, 20] == pytest.approx(3.0)


def test_the_crest_follows_the_ground_and_the_side_below_is_longer():
    z = with_dams(plane(0.5), [Dam(name="wall", line=[[20.0, 0.0], [20.0, 40.0]], height=4.0, slope=45.0)]).z[20]
    assert z[20] == pytest.approx(-10.0 + 4.0)
    # uphill the side meets the ground after H / (1 + 0.5) = 2.7 m, downhill after H / (1 - 0.5) = 8 m
    assert z[18] == pytest.approx(-8.0)
    assert z[17] == pytest.approx(-8.5)
    assert z[27] == pytest.approx(-13.0)
    assert z[29] == pytest.approx(-14.5)


def test_the_volume_of_a_straight_dam():
    """H^2 / tan(slope) + w H per length, and two half cones at its ends."""
    raster = plane(n=401, cell=0.1)
    dam = Dam(name="wall", line=[[20.0, 10.0], [20.0, 30.0]], height=3.0, slope=30.0, crest_width=1.0)
    z, t = with_dams(raster, [dam]).z, np.tan(np.radians(30.0))
    r, foot = 0.5, 3.0 / t
    cone = np.pi * (3.0 * r**2 + 2.0 * (3.0 * (foot**2 / 2 + r * foot) - t * (foot**3 / 3 + r * foot**2 / 2)))
    assert z.sum() * 0.01 == pytest.approx(20.0 * (9.0 / t + 3.0) + cone, rel=2e-3)


@pytest.mark.parametrize(("line", "says"), [
    ([[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]], "crosses itself"),
    ([[0.0, 0.0], [0.0, 0.0]], "repeats"),
])
def test_wrong_lines_are_refused(line, says):
    with pytest.raises(ValueError, match=says):
        Dam(name="wall", line=line, height=3.0)


def test_a_dam_off_the_terrain_is_refused_and_a_thin_one_warned_of():
    with pytest.raises(InputError, match="lies off the terrain"):
        with_dams(plane(), [Dam(name="wall", line=[[100.0, 0.0], [100.0, 9.0]], height=3.0)])
    with pytest.raises(InputError, match="partly off the terrain"):
        with_dams(plane(), [Dam(name="wall", line=[[20.0, 0.0], [60.0, 0.0]], height=3.0)])
    with pytest.warns(UserWarning, match=r"less than 2 cells"):
        with_dams(plane(), [Dam(name="wall", line=[[20.0, 5.0], [20.0, 35.0]], height=0.5)])


def flow(folder, height, angle=90.0, end_time=18.0):
    """A sheet that slides down a plane of 20 degrees without friction, against a dam across it or at an angle to the
    fall line."""
    n, cell = 81, 2.0
    x = np.arange(n) * cell
    z = np.broadcast_to(-np.tan(np.radians(20.0)) * x, (41, n))
    header = f"ncols {n}\nnrows 41\nxllcenter 0\nyllcenter 0\ncellsize {cell}\nNODATA_value -9999\n"
    (folder / "plane.asc").write_text(header + "\n".join(" ".join(f"{v:.4f}" for v in row) for row in z))
    reach = 30.0
    along, across = reach * np.cos(np.radians(angle)), reach * np.sin(np.radians(angle))
    dam = {"name": "dam", "line": [[100.0 - along, 40.0 - across], [100.0 + along, 40.0 + across]], "height": height,
           "slope": 60.0}
    scene = Scene.model_validate({
        "name": "dam", "dimension": 3, "end_time": end_time, "output": {"interval": 6.0, "fields": ["volume"]},
        "solver": {"method": "depth", "dx": 2.0, "precision": "f64"},
        "terrain": {"kind": "dem", "file": str(folder / "plane.asc"), "friction": 0.2, "dams": [dam] if height else []},
        "materials": {"snow": {"kind": "elastic", "density": 200.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "sheet", "material": "snow", "shape": {
            "kind": "layer", "top": 1.0, "region": {"x": [20.0, 40.0], "y": [30.0, 50.0]}}}]})
    run = snowmpm.run(scene, folder / f"run{height:g}_{angle:g}")
    frame = run.frame(-1)
    return frame.points + run.origin, frame.fields["volume"], run.history["removed_mass"][-1] / 200.0


def test_a_high_dam_holds_the_flow_back_and_a_low_one_is_overtopped(tmp_path):
    """The sheet comes at about 13 m/s after 60 m: v^2 / 2g = 9 m, less what the impact takes."""
    past = {}
    for height in (0.0, 1.5, 20.0):
        points, volume, gone = flow(tmp_path, height)
        past[height] = (volume[points[:, 0] > 102.0].sum() + gone) / (volume.sum() + gone)
    assert past[0.0] > 0.95
    assert past[20.0] < 0.02
    assert past[20.0] < past[1.5] < past[0.0] + 1e-5


def test_an_oblique_dam_deflects_the_flow(tmp_path):
    straight, aside = (np.average(points[:, 1], weights=volume) for points, volume, _ in (
        flow(tmp_path, 0.0, end_time=10.0), flow(tmp_path, 10.0, angle=40.0, end_time=10.0)))
    assert abs(straight - 40.0) < 1.0
    assert abs(aside - 40.0) > 5.0

"""`maps --over-time`: rasters and films of the flow at several times, layers for the time slider, before and after."""

from types import SimpleNamespace
from xml.etree import ElementTree as xml

import imageio.v2 as imageio
import numpy as np
import pytest

from snowmpm.cli.app import app
from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter
from snowmpm.io.flow_maps import NAMES, FlowMaps, moments

pytest.importorskip("rasterio")
CELL, SPACING, SPEED, INTERVAL, FRAMES = 10.0, 2.5, 5.0, 2.0, 4
SHAPE = 6, 12
ORIGIN = np.array([6e5, 2e5, 1e3])


def write(folder, frames=FRAMES, depth=None):
    """A block of 20 m by 20 m, two particles deep, that moves by a map cell each frame; with depth [m]: as columns on
    ground of 30 degrees."""
    x, y = (g.ravel() for g in np.meshgrid(np.arange(10.0, 30.0, SPACING), np.arange(20.0, 40.0, SPACING)))
    plan = np.column_stack([x, y]) + 0.5 * SPACING
    plan = np.concatenate([plan, plan]) if depth is None else plan
    corners = np.array([[0.0, 0.0], [120.0, 0.0], [120.0, 60.0], [0.0, 60.0]])
    terrain = np.column_stack([corners, -np.tan(np.radians(30.0)) * corners[:, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    units = {"velocity": "m/s", "depth": "m"}
    with RunWriter(folder, provenance={"scene_name": "block", "particle_spacing": SPACING}, origin=ORIGIN,
                   terrain=terrain, units=units) as writer:
        for k in range(frames):
            now = plan + np.array([CELL * k, 0.0])
            fields = {"velocity": np.full((len(now), 3), [SPEED, 0.0, 0.0])}
            fields |= {} if depth is None else {"depth": np.full(len(now), depth)}
            writer.frame(INTERVAL * k, np.column_stack([now, -np.tan(np.radians(30.0)) * now[:, 0]]), fields)
        peak = np.zeros(SHAPE)
        peak[2:4, 1 : 3 + frames - 1] = 5.0
        places = {"peak_depth": peak, "release_depth": peak * (np.arange(12) < 3),
                  "deposit_depth": peak * (np.arange(12) >= frames)}
        for name, values in places.items():
            writer.map(name, values, 0.5 * CELL, 0.5 * CELL, CELL, "m")
        writer.hazard({"numbers": {"flow_depth": 0.5, "release_area": 400.0}})
    return Run(folder)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Run, folder and project of `maps --over-time gif`."""
    folder = tmp_path_factory.mktemp("over_time")
    run = write(folder / "run")
    with pytest.raises(SystemExit) as end:
        app(["maps", str(folder / "run"), "-o", str(folder / "maps"), "--over-time", "gif", "-q"])
    assert not end.value.code
    root = xml.parse(folder / "maps" / "avalanche.qgs").getroot()
    return SimpleNamespace(run=run, folder=folder / "maps", root=root)


def test_depth_is_the_volume_over_each_cell_and_speed_its_mean(made):
    import rasterio

    depth = 2.0 * SPACING  # two particles over each of their squares
    for k in range(FRAMES):
        with rasterio.open(made.folder / "over_time" / f"momentary_depth_{k:05d}.tif") as file:
            values = file.read(1, masked=True)[::-1]  # north is up in the file
            assert file.bounds.left == ORIGIN[0] and file.bounds.bottom == ORIGIN[1]
        expected = np.zeros(SHAPE)
        expected[2:4, 1 + k : 3 + k] = depth
        assert np.allclose(values.filled(0.0), expected) and (values.mask == (expected == 0.0)).all()
        with rasterio.open(made.folder / "over_time" / f"momentary_speed_{k:05d}.tif") as file:
            assert np.allclose(file.read(1, masked=True).compressed(), SPEED)


def test_time_slider_shows_each_moment_alone(made):
    layers = [one for one in made.root.iter("maplayer") if one.find("temporal") is not None]
    assert len(layers) == len(NAMES) * FRAMES
    for name in NAMES:
        own = [one for one in layers if name in one.findtext("datasource")]
        spans = [(one.findtext("temporal/fixedRange/start"), one.findtext("temporal/fixedRange/end")) for one in own]
        # Both ends count: each range ends a second before the next begins
        assert spans == [(f"2000-01-01T00:00:0{2 * k}Z", f"2000-01-01T00:00:0{2 * k + 1}Z") for k in range(FRAMES)]
        assert all((made.folder / one.findtext("datasource")).is_file() for one in own)
        assert all(one.find("temporal").attrib == {"enabled": "1", "mode": "0", "fetchMode": "0"} for one in own)
        assert all(one.find("pipe/rasterrenderer") is not None for one in own)
    settings = made.root.find("ProjectTimeSettings")
    assert settings.get("timeStep") == "2" and settings.get("timeStepUnit") == "s"
    assert (settings.findtext("TemporalRange/start"), settings.findtext("TemporalRange/end")) == (
        "2000-01-01T00:00:00Z", "2000-01-01T00:00:07Z")
    groups = made.root.findall("layer-tree-group/layer-tree-group")
    assert [group.get("checked") for group in groups] == ["Qt::Unchecked", "Qt::Unchecked"]
    leaves = [leaf.get("id") for group in groups for leaf in group]
    assert sorted(leaves) == sorted(one.findtext("id") for one in layers) and len(set(leaves)) == len(leaves)


def test_film_shows_the_block_move_and_nothing_else_but_the_time(made):
    pictures = [np.asarray(one)[..., :3].astype(int) for one in imageio.mimread(made.folder / "momentary_depth.gif")]
    assert len(pictures) == FRAMES
    below = slice(60, None)  # the title, with the time, above
    blue = [(picture[below, :, 2] - picture[below, :, 0] > 60) for picture in pictures]
    across = [np.flatnonzero(one[:, : int(0.8 * one.shape[1])].any(axis=0)).mean() for one in blue]
    steps = np.diff(across)
    assert (steps > 10.0).all() and np.ptp(steps) <= 3.0  # as far each time: a cell
    moved = (np.abs(pictures[0] - pictures[-1]).max(axis=-1) > 40)[below]
    assert moved.any() and not moved[:, int(0.85 * moved.shape[1]) :].any()  # the colour bar stays
    assert (made.folder / "before_after.png").is_file()


def test_columns_have_vertical_depth(tmp_path):
    values = FlowMaps(write(tmp_path, 2, depth=1.5)).at(0)["momentary_depth"]
    assert np.nanmax(values) == pytest.approx(np.nanmin(values)) == pytest.approx(1.5 / np.cos(np.radians(30.0)))
    assert np.isfinite(values).sum() == 4


def test_moments_are_some_forty_frames_with_the_first_and_the_last():
    class Long(SimpleNamespace):
        def __len__(self):
            return len(self.times)

    found = moments(Long(maps={"peak_depth": None}, field_names=["velocity"], times=np.arange(0.0, 100.1, 0.25)))
    assert len(found) == 40 and found[0][:2] == (0, 0.0) and found[-1][1] == 100.0
    begins, ends = np.array([one[1] for one in found]), np.array([one[2] for one in found])
    assert (ends[:-1] == begins[1:]).all() and len(set(begins.round())) == 40


def test_runs_without_frames_over_time_and_other_kinds_are_refused(tmp_path, call):
    with pytest.raises(InputError, match="no maps over time"):
        moments(write(tmp_path / "one", frames=1))
    result = call("maps", tmp_path / "one", "--over-time", "avi")
    assert result.code == 2 and "--over-time" in result.err and not (tmp_path / "one" / "maps").exists()

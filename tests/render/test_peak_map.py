"""Rasters of a run drawn over its terrain."""

import imageio.v2 as imageio
import numpy as np
import pytest
from synthetic_runs import slab_2d, slab_3d

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter
from snowmpm.io.built import dam_lines, footprints
from snowmpm.render import render_map
from snowmpm.render.credit import attribution
from snowmpm.render.peak_map import map_figure


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("run")
    slab_3d(path, particles=500, frames=1, origin=(5.0e5, 2.0e5, 1.5e3), hole=True)
    return path


def test_map_shows_the_raster_over_grey_terrain(folder, tmp_path):
    path = render_map(folder, "peak_depth", tmp_path / "maps" / "depth.png", dpi=60)
    picture = imageio.imread(path)[..., :3].astype(int)
    colourful = np.ptp(picture, axis=-1) > 60
    grey = (np.ptp(picture, axis=-1) < 12) & (picture.mean(axis=-1) > 60) & (picture.mean(axis=-1) < 235)
    assert 0.02 < colourful.mean() < 0.4
    assert grey.mean() > 0.2
    assert [entry.name for entry in path.parent.iterdir()] == ["depth.png"]


def test_the_title_lies_within_the_picture(folder, tmp_path):
    """White rows above it, at any resolution."""
    for dpi in (60, 110, 150):
        picture = imageio.imread(render_map(folder, "peak_depth", tmp_path / "depth.png", dpi=dpi))[..., :3]
        assert (picture[: dpi // 15] == 255).all() and (picture[: dpi // 3] < 128).any()


def test_map_of_a_run_without_terrain_is_drawn(tmp_path):
    with RunWriter(tmp_path, provenance={}) as writer:
        writer.map("peak_speed", np.eye(12), 0.0, 0.0, 5.0, "m/s")
    assert render_map(tmp_path, "peak_speed", tmp_path / "speed.png", dpi=50).stat().st_size > 1000


SCENE = """
[terrain]
kind = "dem"
dams = [{ name = "catching dam", line = [[500150.0, 199990.0], [500150.0, 200010.0]], height = 5.0 }]
"""


def test_what_was_built_stands_on_the_map(tmp_path):
    slab_3d(tmp_path, particles=500, frames=1, origin=(5.0e5, 2.0e5, 1.5e3), obstacles=True)
    run = Run(tmp_path)
    run.provenance["scene"] = SCENE
    found = footprints(run)
    assert set(found) == {"house", "mast"}
    assert found["house"].bounds == pytest.approx((500121.0, 200001.0, 500129.0, 200011.0))
    assert found["mast"].area == pytest.approx(np.pi * 0.6**2, rel=0.02)
    assert dam_lines(run)["catching dam"].tolist() == [[500150.0, 199990.0], [500150.0, 200010.0]]
    words = [text.get_text() for text in map_figure(run, "peak_depth").axes[0].texts]
    assert {"house", "mast", "catching dam"} <= set(words)


def test_credits_are_found_at_any_depth():
    record = {"scene": {"terrain": {"attribution": "survey A"}, "layers": [{"attribution": "B"}, {"attribution": "B"}]}}
    assert attribution(record) == "survey A; B"
    assert attribution({"scene": None}) == ""


def test_bad_wishes_are_refused(folder, tmp_path):
    with pytest.raises(InputError, match="peak_depth"):
        render_map(folder, "peak_dpeth", tmp_path / "a.png")
    with pytest.raises(InputError, match=r"\.svg"):
        render_map(folder, "peak_depth", tmp_path / "a.doc")
    slab_2d(tmp_path / "flat", frames=1)
    with pytest.raises(InputError, match="none"):
        render_map(tmp_path / "flat", "peak_depth", tmp_path / "a.png")
    with RunWriter(tmp_path / "empty", provenance={}) as writer:
        writer.map("peak_depth", np.full((3, 3), np.nan), 0.0, 0.0, 1.0, "m")
    with pytest.raises(InputError, match="no values"):
        render_map(tmp_path / "empty", "peak_depth", tmp_path / "a.png")

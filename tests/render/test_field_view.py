"""Slices, arrows, streamlines and values along lines, from fields that are known."""

import numpy as np
import pytest
from PIL import Image

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter
from snowmpm.render import render_line, render_run
from snowmpm.render.gridded import COUNT, along_line, gridded
from snowmpm.render.run_film import view_of
from tests.render import synthetic_runs

SPACING, ORIGIN = 0.1, (100.0, 200.0, 0.0)
SIZE = (320, 180)


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    """2 m by 1 m by 1 m of particles that turn about a vertical axis; density 100 + 50 x."""
    path = tmp_path_factory.mktemp("block")
    axes = [np.arange(0.5 * SPACING, size, SPACING) for size in (2.0, 1.0, 1.0)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    velocity = np.column_stack([-(points[:, 1] - 0.5), points[:, 0] - 1.0, np.zeros(len(points))])
    stress = np.tile([-3.0, -3.0, -3.0, 0.0, 0.0, 0.0], (len(points), 1))
    with RunWriter(path, provenance={"particle_spacing": SPACING, "scene_name": "block"}, origin=ORIGIN,
                   units={"density": "kg/m3", "velocity": "m/s", "stress": "Pa"}) as writer:
        for time in (0.0, 1.0):
            writer.frame(time, points, {"density": 100.0 + 50.0 * points[:, 0], "velocity": velocity, "stress": stress})
    return Run(path)


def test_means_of_cells(block):
    grid = gridded(block, 0, ["density", "velocity"])
    assert grid.spacing == pytest.approx((2.0 * SPACING,) * 3)
    counts = np.asarray(grid.cell_data[COUNT])
    assert counts.sum() == 2000 and (counts == 8).all()
    centres = np.asarray(grid.cell_centers().points)
    assert np.asarray(grid.cell_data["density"]) == pytest.approx(100.0 + 50.0 * centres[:, 0], rel=1e-5)
    turning = np.column_stack([0.5 - centres[:, 1], centres[:, 0] - 1.0, np.zeros(len(centres))])
    assert np.asarray(grid.cell_data["velocity"]) == pytest.approx(turning, abs=1e-5)


def test_values_along_a_line(block, tmp_path):
    distance, values = along_line(block, 1, "density", (-0.5, 0.5, 0.5), (2.5, 0.5, 0.5), 301)
    inside = (distance > 0.55) & (distance < 2.35)
    assert np.abs(values - (100.0 + 50.0 * (distance - 0.5)))[inside].max() < 50.0 * 2.0 * SPACING
    assert np.isnan(values[distance < 0.4]).all() and np.isnan(values[distance > 2.7]).all()
    assert along_line(block, 0, "stress", (0.2, 0.5, 0.5), (1.0, 0.5, 0.5))[1] == pytest.approx(3.0)
    begin, end = np.add(ORIGIN, (-0.5, 0.5, 0.5)), np.add(ORIGIN, (2.5, 0.5, 0.5))
    picture, table = render_line(block, tmp_path / "line.png", begin, end, field="density")
    assert Image.open(picture).size[0] > 200
    rows = [row.split(",") for row in table.read_text().strip().splitlines()]
    assert rows[0] == ["distance_m", "density"] and len(rows) == 201 and rows[1][1] == ""
    for places, options, said in (((begin, begin), {}, "apart"), ((begin, end), {"field": "mood"}, "color"),
                                  ((end, end + 1.0), {}, "no snow")):
        with pytest.raises(InputError, match=said):
            render_line(block, tmp_path / "other.png", *places, **options)
    assert not (tmp_path / "other.png").exists()


def drawn(run, look, **options):
    view = view_of(run, SIZE, look=look, **options)
    view.plain = True
    try:
        return view.picture(0).astype(int)
    except InputError as error:
        if "OpenGL" in str(error):
            pytest.skip(str(error))
        raise


def test_a_slice_shows_the_field_on_its_plane(block):
    """Seen from y = -: density rises to the right, by colours whose limits are those of the run."""
    view = view_of(block, SIZE, look="slice", color="density", camera="180,0", at="y=200.5")
    picture = drawn(block, "slice", color="density", camera="180,0", at="y=200.5")
    x, y, _ = view.camera.project(np.array([[0.3, 0.5, 0.5], [1.7, 0.5, 0.5]]))  # middles of cells
    for column, row, density in zip(x, y, (115.0, 185.0), strict=True):
        found = picture[int(row), int(column)]
        wanted = 255.0 * view.scale.table()[round(255 * float(view.scale.share([density])[0]))]
        assert np.abs(found - wanted).max() <= 3  # steps of the table


@pytest.mark.parametrize("look", ["arrows", "streamlines"])
def test_velocities_are_drawn(block, look):
    with_it, without = drawn(block, look), drawn(block, "slice", at="z=50")
    assert np.abs(with_it - without).max() > 60
    assert 200 < (np.abs(with_it - without).max(axis=2) > 30).sum() < 0.6 * SIZE[0] * SIZE[1]


def test_what_is_refused(block, tmp_path):
    section = tmp_path / "section"
    synthetic_runs.slab_2d(section, spacing=0.5, frames=2)
    for run, options, said in ((Run(section), {"look": "slice"}, "three dimensions"),
                               (block, {"look": "slice", "at": "w=3"}, "y=13"),
                               (block, {"look": "arrows", "at": "x=1"}, "slice"),
                               (block, {"at": "x=1"}, "slice"),
                               (block, {"look": "slice", "color": "snow"}, "shows a field")):
        with pytest.raises(InputError, match=said):
            render_run(run, tmp_path / "a.png", **options)
    assert not (tmp_path / "a.png").exists()

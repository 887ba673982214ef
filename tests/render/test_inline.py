"""Runs at a prompt and in a notebook: pictures, an interactive view, PyVista; progress; no start lines."""

import html
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import snowmpm
from snowmpm.errors import InputError
from snowmpm.io import RunWriter
from tests.render import synthetic_runs


@pytest.fixture(scope="module")
def space(tmp_path_factory):
    """3-D with terrain, obstacles and an origin far away."""
    path = tmp_path_factory.mktemp("space")
    synthetic_runs.slab_3d(path, particles=500, frames=3, origin=(6.0e5, 2.0e5, 1.5e3), obstacles=True)
    return snowmpm.open_run(path)


@pytest.fixture(scope="module")
def flat(tmp_path_factory):
    path = tmp_path_factory.mktemp("flat")
    snowmpm.run(snowmpm.load_scene(Path(__file__).parents[1] / "cli" / "block.toml"), path)
    return snowmpm.open_run(path)


def test_a_frame_as_pyvista(space):
    """Snow with its fields and units, terrain and obstacles, all in map coordinates."""
    frame = space.frame(1)
    blocks = frame.to_pyvista()
    assert list(blocks.keys()) == ["snow", "terrain", *space.obstacles]
    snow = blocks["snow"]
    assert np.array_equal(snow.points, frame.positions) and snow.points.dtype == np.float64
    for name, values in frame.fields.items():
        assert np.array_equal(snow.point_data[name], values)
        assert snow.user_dict["units"][name] == space.units[name]
    assert snow.user_dict["time"] == frame.time
    ground = blocks["terrain"]
    assert np.allclose(ground.points, space.terrain.vertices + space.origin)
    assert np.array_equal(ground.regular_faces, space.terrain.facets)
    for name, obstacle in space.obstacles.items():
        assert np.allclose(blocks[name].points, obstacle.placed(1) + space.origin)
    assert np.array_equal(space.frame(-1).to_pyvista()["snow"].points, space.frame(len(space) - 1).positions)


def test_a_section_as_pyvista(flat):
    blocks = flat.frame(0, ["velocity"]).to_pyvista()
    assert list(blocks["snow"].point_data) == ["velocity"]
    if flat.terrain is not None:
        assert blocks["terrain"].n_lines == len(flat.terrain.facets)


def test_a_plotter_has_everything(space):
    import pyvista

    plotter = space.plotter(1)
    assert isinstance(plotter, pyvista.Plotter)
    assert {"snow", "terrain", *space.obstacles, "time"} <= set(plotter.actors)
    assert any("speed [m/s]" in title for title in plotter.scalar_bars.keys())  # noqa: SIM118
    with pytest.raises(InputError, match="colour of the sky"):
        space.plotter(0, color="colour of the sky", off_screen=True)
    plotter.close()


def test_pictures_inline(flat, tmp_path):
    pictures = flat.plot()
    assert list(pictures.pictures) == ["still", "history"]
    shown = pictures._repr_mimebundle_()["text/html"]
    assert shown.count("<img") == 2 and 'alt="history"' in shown
    still = flat.plot("still")._repr_mimebundle_()
    assert "text/html" not in still and Image.open(io.BytesIO(still["image/png"])).size == (1280, 720)
    assert [path.name for path in pictures.save(tmp_path / "run.png")] == ["run_still.png", "run_history.png"]
    assert [path.name for path in flat.plot("history").save(tmp_path / "one.png")] == ["one.png"]
    with pytest.raises(InputError, match=r"peak_depth.*must be one of"):
        flat.plot("peak_depth")
    with pytest.raises(InputError, match=r"must end in \.png"):
        pictures.save(tmp_path / "run.jpg")


def test_maps_by_name(tmp_path):
    with RunWriter(tmp_path, provenance={}) as writer:
        writer.map("peak_depth", np.ones((4, 5)), 0.0, 0.0, 1.0, "m")
    run = snowmpm.open_run(tmp_path)
    assert list(run.plot("peak_depth").pictures) == ["peak_depth"]
    assert "<img" not in run._repr_html_()  # without frames there is nothing to show yet


def test_a_view_needs_no_network(space, tmp_path):
    """The page in a frame: it may run its own scripts, and nothing else; names in it are escaped."""
    view = space.show()
    element = view._repr_html_()
    page = html.unescape(re.search(r'srcdoc="([^"]*)"', element)[1])
    assert page == view.page and 'sandbox="allow-scripts"' in element
    assert not re.search(r'(src|href)="https?://', page) and "<canvas" in page
    assert view.save(tmp_path / "view.html").read_text(encoding="utf-8") == view.page
    with pytest.raises(InputError, match=r"must end in \.html"):
        view.save(tmp_path / "view.txt")


def test_a_glance_has_a_table_and_a_picture(flat, space):
    for run in (flat, space):
        shown = run._repr_html_()
        assert "<table>" in shown and shown.count("<img") == 1 and len(shown) < 150_000


def test_a_picture_is_of_the_run_that_is_there_now(tmp_path, monkeypatch):
    """The same folder written anew, and another folder of the same name."""
    def write(place, high):
        place.mkdir(parents=True, exist_ok=True)
        with RunWriter(place, provenance={}, dimension=2) as writer:
            writer.frame(0.0, np.random.default_rng(1).random((50, 3)) * [1.0, 0.0, high], {})
        return place

    write(tmp_path / "a" / "r", 1.0), write(tmp_path / "b" / "r", 3.0)
    found = []
    for folder in ("a", "b"):
        monkeypatch.chdir(tmp_path / folder)
        found.append(snowmpm.open_run("r")._repr_html_())
    write(tmp_path / "b" / "r", 5.0)
    found.append(snowmpm.open_run("r")._repr_html_())
    pictures = {re.search(r"base64,([^\"]*)", one)[1] for one in found}
    assert len(pictures) == 3


def test_odd_frames_as_pyvista(tmp_path):
    """None but the frame that was meant, also after more have come; obstacles of odd names; no particles at all."""
    shape = (np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.array([[0, 1, 2]]))
    with RunWriter(tmp_path, provenance={}, obstacles={"snow": shape, "wall": shape}) as writer:
        writer.frame(0.0, np.zeros((3, 3)), {}, poses={"wall": (np.eye(3), np.zeros(3))})
        run = snowmpm.open_run(tmp_path)
        last = run.frame(-1)
        writer.frame(1.0, np.zeros((0, 3)), {}, poses={"wall": (np.eye(3), np.array([10.0, 0.0, 0.0]))})
    run.refresh()
    blocks = last.to_pyvista()
    assert blocks["snow"].n_points == 3 and blocks["snow (obstacle)"].n_points == 3
    assert blocks["wall"].points[:, 0].max() == 1.0
    assert run.frame(1).to_pyvista()["wall"].points[:, 0].max() == 11.0
    assert run.frame(1).to_pyvista()["snow"].n_points == 0
    with RunWriter(tmp_path / "empty", provenance={}):
        pass
    with pytest.raises(InputError, match="no frame"):
        snowmpm.open_run(tmp_path / "empty").plotter()


def test_progress_is_told_to_what_can_be_called(tmp_path):
    """Also to a callable that counts as empty; True and False are no callables."""
    class Told(list):
        __call__ = list.append

    told, block = Told(), Path(__file__).parents[1] / "cli" / "block.toml"
    for progress in (told, True, False):
        snowmpm.run(snowmpm.load_scene(block), tmp_path, progress=progress)
    assert told


CELLS = ("""
import snowmpm
scene = snowmpm.load_scene(BLOCK)
run = snowmpm.run(scene, "run")
run
""", "run.plot('history')", "run.show()", "snowmpm.run(scene, 'silent', progress=False);", """
snowmpm.run(snowmpm.load_scene(BLOCK, {"materials.snow.youngs_modulus": 1e6, "solver.dt": 1.0}), "failing")
""")


@pytest.fixture(scope="module")
def notebook(tmp_path_factory):
    """Outputs of each cell of a notebook in its own kernel, without a display."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    block = Path(__file__).parents[1] / "cli" / "block.toml"
    cells = [nbformat.v4.new_code_cell(text.replace("BLOCK", repr(str(block)))) for text in CELLS]
    made = nbformat.v4.new_notebook(cells=cells)
    client = nbclient.NotebookClient(made, timeout=300, allow_errors=True, resources={
        "metadata": {"path": str(tmp_path_factory.mktemp("notebook"))}})
    client.execute(env={**{k: v for k, v in os.environ.items() if k != "DISPLAY"}, "PYTHONWARNINGS": "ignore"})
    return [cell.outputs for cell in made.cells]


def texts(outputs, kind="text/html"):
    return [output.data[kind] for output in outputs if "data" in output and kind in output.data]


def test_a_run_in_a_notebook_shows_a_bar_and_no_start_line(notebook):
    first = notebook[0]
    assert [output for output in first if output.output_type == "stream"] == []
    bar, run = texts(first)
    assert 'value="1.0000"' in bar and "block" in bar and "done in" in bar
    assert "<table>" in run and "<img" in run


def test_pictures_and_views_in_a_notebook(notebook):
    assert texts(notebook[1]) == [] and len(texts(notebook[1], "image/png")) == 1
    assert "<iframe" in texts(notebook[2])[0]


def test_the_bar_can_be_left_out_and_tells_of_failure(notebook):
    assert not any("<progress" in text for text in texts(notebook[3]))
    assert notebook[4][-1].output_type == "error"
    assert "failed after" in texts(notebook[4])[0]


def test_a_program_prints_nothing_at_its_start():
    """Neither Taichi's greeting nor its start line, also where standard output is not the terminal's."""
    code = ("import io, sys; sys.stdout = io.StringIO(); import snowmpm; snowmpm.start('cpu');"
            "sys.__stdout__.write(sys.stdout.getvalue())")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")

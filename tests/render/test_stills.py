"""A sheet of stills: which moments, where, and what is refused."""

import numpy as np
import pytest
from PIL import Image
from synthetic_runs import slab_2d
from typer.testing import CliRunner

from snowmpm.cli.app import app
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import render_stills
from snowmpm.render.run_film import view_of
from snowmpm.render.stills import GAP


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    slab_2d(folder, spacing=0.3, frames=9, duration=8.0)
    return Run(folder)


@pytest.mark.parametrize(("count", "columns", "rows", "frames"), [
    (1, 1, 1, [0]), (3, 2, 2, [0, 4, 8]), (5, 3, 2, [0, 2, 4, 6, 8]),
])
def test_moments_are_even_over_time_and_lie_row_by_row(run, tmp_path, count, columns, rows, frames):
    path = render_stills(run, tmp_path / "sheet.png", count, size=(480, 240))
    with Image.open(path) as image:
        sheet = np.asarray(image)
    width, height = (480 - GAP * (columns - 1)) // columns, (240 - GAP * (rows - 1)) // rows
    view = view_of(run, (width, height))
    for k, i in enumerate(frames):
        row, column = k // columns * (height + GAP), k % columns * (width + GAP)
        assert np.array_equal(sheet[row : row + height, column : column + width], view.picture(i))
    assert sheet.shape[0] <= 240 and sheet.shape[1] <= 480


def test_a_part_of_the_run(run, tmp_path):
    render_stills(run, tmp_path / "part.png", 2, size=(480, 120), begin=2.0, end=4.0)
    with Image.open(tmp_path / "part.png") as image:
        sheet = np.asarray(image)
    width = (480 - GAP) // 2
    view = view_of(run, (width, 120))
    assert np.array_equal(sheet[:, :width], view.picture(2)) and np.array_equal(sheet[:, -width:], view.picture(4))


@pytest.mark.parametrize(("options", "key"), [
    ({"output": "a.mp4"}, "ends in"), ({"count": 0}, "stills = 0"), ({"count": 99}, "from 1 to 36"),
    ({"begin": 9.0}, "goes from 0 to 8"), ({"begin": 4.0, "end": 2.0}, "must be before"),
    ({"count": 36, "size": (200, 100)}, "size"),
])
def test_what_is_no_sheet_is_refused(run, tmp_path, options, key):
    options = {"output": "a.png", "count": 2, **options}
    with pytest.raises(InputError, match=key):
        render_stills(run, tmp_path / options.pop("output"), **options)
    assert not list(tmp_path.iterdir())


def test_the_command_writes_one_and_names_what_does_not_go_with_it(run, tmp_path):
    known = CliRunner().invoke(app, ["render", str(run.path), "--stills", "2", "--size", "320x90", "-o",
                                     str(tmp_path / "two.jpg")])
    assert known.exit_code == 0 and (tmp_path / "two.jpg").stat().st_size > 1000
    refused = CliRunner().invoke(app, ["render", str(run.path), "--stills", "2", "--time", "1", "--speed", "2"])
    assert refused.exit_code != 0 and "--time, --speed: not with a sheet of stills" in refused.output

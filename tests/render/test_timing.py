"""How a film's time goes: which frames it shows, at which pace, what its clock says; and pictures without words."""

import imageio_ffmpeg
import numpy as np
import pytest
import synthetic_runs

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import render_pair, render_run
from snowmpm.render.run_film import view_of
from snowmpm.render.timing import Timing, pace_in_words

TIMES = np.linspace(0.0, 2.0, 21)  # every 0.1 s
SIZE = (160, 90)


@pytest.fixture(scope="module")
def section(tmp_path_factory):
    path = tmp_path_factory.mktemp("section")
    synthetic_runs.slab_2d(path, spacing=0.4, frames=5, duration=2.0)
    return Run(path)


@pytest.mark.parametrize(("timing", "frames", "pace"), [
    (Timing(), range(21), 2.5),
    (Timing(fps=10), range(21), 1.0),
    (Timing(every=2), range(0, 21, 2), 5.0),
    (Timing(begin=0.5, end=0.8), [5, 6, 7, 8], 2.5),
    (Timing(begin=0.51, end=0.52), [5], None),
    (Timing(fps=10, speed=1.0), range(21), 1.0),
    (Timing(fps=10, speed=2.0), range(0, 21, 2), 2.0),
    (Timing(fps=10, speed=0.5, begin=0.0, end=0.2), [0, 0, 1, 1, 2], 0.5),
])
def test_which_frames_and_how_fast(timing, frames, pace):
    timing.check("run", TIMES)
    np.testing.assert_array_equal(timing.frames(TIMES), list(frames))
    assert timing.pace(TIMES) == pytest.approx(pace)


def test_frames_at_uneven_times_are_the_nearest():
    times = np.array([0.0, 0.1, 0.5, 1.0])
    np.testing.assert_array_equal(Timing(fps=4, speed=1.0).frames(times), [0, 1, 2, 2, 3])


def test_in_words():
    assert [pace_in_words(pace) for pace in (None, 1.004, 2.5, 0.25)] == [
        "", "real time", "2.5 times real time", "0.25 times real time"]


@pytest.mark.parametrize(("wishes", "said"), [
    ({"speed": 0.0}, "speed"), ({"fps": 0.0}, "fps"), ({"every": 0}, "every"), ({"begin": 3.0}, "from"),
    ({"end": -1.0}, "to"), ({"begin": 1.5, "end": 1.0}, "from"), ({"speed": 1e-9}, "pictures"),
    ({"speed": 1.0, "every": 2}, "--every"),
])
def test_bad_wishes(wishes, said):
    with pytest.raises(InputError, match=said):
        Timing(**wishes).check("run", TIMES)


def test_a_film_lasts_as_long_as_its_speed_says(section, tmp_path):
    path = render_run(section, tmp_path / "film.mp4", size=SIZE, timing=Timing(fps=10, speed=0.5))
    pictures, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert pictures == 41 and seconds == pytest.approx(4.1, abs=0.05)
    folder = render_run(section, tmp_path / "pictures", size=SIZE, timing=Timing(begin=0.9, end=2.0, every=2))
    assert len(list(folder.iterdir())) == 2
    with pytest.raises(InputError, match="--time chooses"):
        render_run(section, tmp_path / "one.png", size=SIZE, timing=Timing(speed=1.0))


def test_the_clock_says_the_pace(section, tmp_path, monkeypatch):
    said = []
    monkeypatch.setattr("snowmpm.render.overlay.Overlay.heading", lambda self, *words: said.append(words[-1]))
    render_run(section, tmp_path / "film", size=SIZE)
    render_pair(section, section, tmp_path / "pair", size=SIZE, timing=Timing(fps=2))
    render_run(section, tmp_path / "one.png", size=SIZE)
    assert said == ["12.5 times real time"] * 5 + ["real time"] * 10 + [""]


def test_a_plain_picture_has_no_words(section, monkeypatch):
    """Nothing is written on it, and where nothing was written before it is the same picture."""
    view = view_of(section, (320, 180))
    usual = view.picture(2)
    for name in ("heading", "colour_scale", "length_scale", "inset", "note"):
        monkeypatch.setattr(f"snowmpm.render.overlay.Overlay.{name}", lambda *_, **__: pytest.fail("drawn upon"))
    view.plain = True
    plain = view.picture(2)
    same = (plain == usual).all(axis=-1)
    assert 0.3 < same.mean() < 1.0

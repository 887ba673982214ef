"""Two runs side by side: one camera, one scale, one time."""

import imageio.v2 as imageio
import numpy as np
import pytest
from synthetic_runs import slab_2d, slab_3d

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import render_pair
from snowmpm.render.pair import PairView


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pairs")
    slab_2d(folder / "coarse", frames=4, duration=6.0, spacing=0.3)
    slab_2d(folder / "fine", frames=9, duration=8.0)
    slab_3d(folder / "near", particles=3000, frames=3)
    slab_3d(folder / "moved", particles=3000, frames=3, origin=(100.0, 50.0, 20.0))
    slab_3d(folder / "far", particles=3000, frames=2, origin=(5.0e4, 0.0, 0.0))
    return {path.name: Run(path) for path in folder.iterdir()}


def test_sections_share_camera_and_limits_and_time(runs):
    view = PairView(runs["coarse"], runs["fine"], (640, 604))
    first, second = view.views
    assert (first.track.scale, first.scale.low, first.scale.high) == (
        second.track.scale, second.scale.low, second.scale.high)
    fastest = max(np.linalg.norm(run.frame(i).fields["velocity"], axis=1).max()
                  for run in view.runs for i in range(len(run)))
    assert first.scale.high > 0.98 * fastest
    assert list(view.times) == list(runs["fine"].times)
    assert [view.title for view in view.views] == ["coarse", "fine"]  # the scenes have one name
    picture = view.picture(8)
    assert picture.shape == (604, 640, 3)
    assert (picture[300:304] == 255).all()
    # At 8 s the one that ended at 6 s shows its end
    assert np.array_equal(picture[:300], first.picture(3)) and np.array_equal(picture[304:], second.picture(8))


def test_space_views_of_one_place_show_it_alike_whatever_their_origin(runs):
    # Both are written relative to their origin, so a run moved with its ground lies elsewhere on the map
    view = PairView(runs["near"], runs["near"], (644, 240))
    first, second = view.views
    assert np.allclose(first.camera.eye, second.camera.eye) and np.allclose(first.camera.axes, second.camera.axes)
    picture = view.picture(1)
    assert picture.shape == (240, 644, 3)
    halves = picture[60:, :320], picture[60:, 324:]
    assert np.abs(np.subtract(*halves, dtype=int)).max() <= 1  # the cameras agree to round-off


def test_runs_of_different_places_each_have_their_view(runs):
    first, second = PairView(runs["near"], runs["far"], (644, 240)).views
    for view in (first, second):
        x, y, _ = view.camera.project(view.run.frame(0).points)
        assert np.mean((x > 0) & (x < 320) & (y > 0) & (y < 240)) > 0.95


def test_film_lasts_as_long_as_the_longer_run(runs, tmp_path):
    path = render_pair(runs["fine"], runs["coarse"], tmp_path / "film.mp4", size=(200, 200), fps=10)
    with imageio.get_reader(path) as film:
        assert film.count_frames() == 9
    render_pair(runs["fine"], runs["coarse"], tmp_path / "one.png", size=(200, 200), time=3.0)
    assert imageio.imread(tmp_path / "one.png").shape == (200, 200, 3)


def test_pairs_that_do_not_fit_are_refused(runs, tmp_path):
    with pytest.raises(InputError, match="dimensions"):
        render_pair(runs["fine"], runs["near"], tmp_path / "film.mp4")
    with pytest.raises(InputError, match="cutaway"):
        render_pair(runs["fine"], runs["coarse"], tmp_path / "film.mp4", cutaway=True)
    assert list(tmp_path.iterdir()) == []

"""Passes for compositing: a see-through sky, and distance along the view."""

import imageio.v2 as imageio
import numpy as np
import pytest
from PIL import Image
from synthetic_runs import slab_2d, slab_3d

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import light, render_run
from snowmpm.render.space_view import SpaceView

SIZE = (160, 90)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    slab_3d(folder, particles=3000, frames=3, obstacles=True)
    return Run(folder)


@pytest.fixture(scope="module")
def pictures(run):
    """Frame 1 plain, transparent and as depth, and the view of them, from low down, so that there is sky."""
    view = SpaceView(run, SIZE, "snow", "20,25")
    view.plain, found = True, {}
    for name in ("picture", "transparent", "depth"):
        view.layer_drawn = name
        found[name] = view.picture(1)
    return view, found


def test_over_the_usual_sky_the_transparent_picture_is_the_usual_one(pictures):
    _, found = pictures
    over = found["transparent"][..., 3:] / 255.0
    assert (over == 0.0).mean() > 0.1 and (over == 1.0).mean() > 0.2
    colour = light.decode(found["transparent"][..., :3] / 255.0)
    again = light.encode((colour * over + light.sky(SIZE) * (1.0 - over)).astype(np.float32)).astype(int)
    assert np.abs(again - found["picture"]).max() <= 4


def test_depth_is_the_distance_along_the_view(run, pictures):
    view, found = pictures
    depth, alpha = found["depth"], found["transparent"][..., 3]
    assert depth.dtype == np.float32 and depth.shape == SIZE[::-1]
    assert np.isinf(depth[alpha == 0]).all() and np.isfinite(depth[alpha == 255]).all()
    house = run.obstacles["house"].vertices
    away = view.camera.project(house)[2]
    x, y, _ = view.camera.project(house.mean(axis=0)[None] + [0.0, 0.0, 5.0])
    assert away.min() - 0.5 < depth[int(y[0]), int(x[0])] < away.max()


def test_passes_are_written_and_read_again(run, tmp_path):
    render_run(run, tmp_path / "sky.png", size=SIZE, camera="20,25", layer="transparent")
    assert imageio.imread(tmp_path / "sky.png").shape == (*SIZE[::-1], 4)
    render_run(run, tmp_path / "depths", size=SIZE, camera="20,25", layer="depth")
    assert sorted(file.name for file in (tmp_path / "depths").iterdir()) == [f"frame_{i:05d}.tif" for i in range(3)]
    with Image.open(tmp_path / "depths" / "frame_00002.tif") as picture:
        numbers = np.array(picture)
    assert numbers.dtype == np.float32 and 10.0 < np.median(numbers[np.isfinite(numbers)]) < 1000.0


@pytest.mark.parametrize(("output", "layer", "told"), [
    ("a.mp4", "transparent", "goes into a .png file or a folder"), ("a.png", "depth", "goes into a .tif file"),
    ("a.tif", "picture", 'is for pass = "depth"'), ("a.png", "alpha", "transparent")])
def test_what_does_not_go_together_is_refused(run, tmp_path, output, layer, told):
    with pytest.raises(InputError, match=told):
        render_run(run, tmp_path / output, layer=layer)
    slab_2d(tmp_path / "flat", frames=1)
    with pytest.raises(InputError):
        render_run(tmp_path / "flat", tmp_path / "b.png", layer="transparent")

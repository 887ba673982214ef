"""The pages in a real browser: headless Chromium draws them, and the screenshot shows the snow where it must be."""

import os
import shutil
import subprocess

import imageio.v2 as imageio
import numpy as np
import pytest
from synthetic_runs import slab_2d, slab_3d, weak_layer_3d

from snowmpm.render import render_page, render_report

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium: apt-get install chromium")]


def screenshot(page, size, folder):
    """Picture (height, width, 3) of a page, and the document as the browser made it."""
    target = folder / "screenshot.png"
    # Without a graphics card Chromium draws WebGL by its own software renderer
    options = ["--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
               "--enable-unsafe-swiftshader", "--hide-scrollbars", f"--user-data-dir={folder / 'profile'}",
               f"--window-size={size[0]},{size[1]}", "--virtual-time-budget=20000"]
    environment = {**os.environ, "HOME": str(folder)}
    for output in ([f"--screenshot={target}"], ["--dump-dom"]):
        done = subprocess.run([CHROMIUM, *options, *output, page.resolve().as_uri()], capture_output=True, text=True,
                              timeout=300, env=environment)
        assert done.returncode == 0, done.stderr[-2000:]
    return imageio.imread(target)[..., :3].astype(int), done.stdout


def snowy(picture):
    """Where the picture is near white."""
    return picture.min(axis=-1) > 215


def warm(picture):
    """Where it has the colours of speed or of a crack."""
    return picture[..., 0] - picture[..., 2] > 70


@pytest.mark.parametrize("make", [slab_3d, slab_2d], ids=["space", "section"])
def test_interactive_page_draws_ground_and_moving_snow(tmp_path, make):
    make(tmp_path / "run", frames=5, obstacles=True)
    page = render_page(tmp_path / "run", tmp_path / "scene.html")
    picture, document = screenshot(page, (900, 600), tmp_path)
    assert 'data-ready="yes"' in document
    scene = picture[60:480, :640]  # without title, legend and bar
    top, bottom = scene[0].mean(axis=0), scene.reshape(-1, 3)
    assert top[2] > top[0] + 10  # sky
    dark = (bottom.max(axis=1) < 170).mean()
    assert dark > 0.05  # ground
    # The made-up runs tell no energy, so the page begins with the end: resting snow; a section's deposit is thin
    assert snowy(scene).sum() > (400 if make is slab_3d else 20)


def test_page_of_a_crack_shows_it(tmp_path):
    weak_layer_3d(tmp_path / "run")
    picture, document = screenshot(render_page(tmp_path / "run", tmp_path / "scene.html", color="fracture"), (900, 600),
                                   tmp_path)
    assert 'data-ready="yes"' in document
    assert warm(picture[60:480, :640]).sum() > 30  # the broken weak layer, at the sides of the slab


def test_report_shows_pictures_scene_and_curves(tmp_path):
    weak_layer_3d(tmp_path / "run")
    page = render_report(tmp_path / "run", tmp_path / "report.html", size=(640, 320))
    picture, document = screenshot(page, (1200, 4200), tmp_path)
    assert 'data-ready="yes"' in document and "How to make it again" in document
    assert picture.shape == (4200, 1200, 3)
    rows = picture.std(axis=(1, 2))
    assert (rows > 25.0).mean() > 0.4  # pictures fill the page
    assert warm(picture).sum() > 2000  # the crack in the cutaway
    assert np.ptp(picture[:60].reshape(-1, 3), axis=0).min() > 150  # the heading, dark on light

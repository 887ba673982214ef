"""The pages in a real browser: headless Chromium draws them, and the screenshot shows the snow where it must be.

They need Chromium (apt-get install chromium), and those that turn and choose need Playwright (pip install playwright).
"""

import base64
import os
import re
import shutil
import subprocess
import time
from contextlib import contextmanager

import imageio.v2 as imageio
import numpy as np
import pytest
from synthetic_runs import slab_2d, slab_3d, weak_layer_3d

from snowmpm.render import render_page, render_report

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium: apt-get install chromium")]


# Without a graphics card Chromium draws WebGL by its own software renderer
SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def screenshot(page, size, folder):
    """Picture (height, width, 3) of a page, and the document as the browser made it."""
    target = folder / "screenshot.png"
    options = ["--headless=new", *SOFTWARE, "--hide-scrollbars", f"--user-data-dir={folder / 'profile'}",
               f"--window-size={size[0]},{size[1]}", "--virtual-time-budget=20000"]
    environment = {**os.environ, "HOME": str(folder)}
    for output in ([f"--screenshot={target}"], ["--dump-dom"]):
        done = subprocess.run([CHROMIUM, *options, *output, page.resolve().as_uri()], capture_output=True, text=True,
                              timeout=300, env=environment)
        assert done.returncode == 0, done.stderr[-2000:]
    return imageio.imread(target)[..., :3].astype(int), done.stdout


@contextmanager
def opened(page, folder, size=(900, 600), touch=False):
    """A page in a Chromium that can be driven, by a mouse or by fingers; complaints of its scripts are errors."""
    playwright = pytest.importorskip("playwright.sync_api", reason="needs Playwright: pip install playwright")
    said = []
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=list(SOFTWARE))
        shape = {"width": size[0], "height": size[1]}
        tab = browser.new_context(viewport=shape, has_touch=touch, is_mobile=touch, offline=True).new_page()
        tab.on("console", lambda message: said.append(message.text))
        tab.on("pageerror", lambda error: said.append(str(error)))
        tab.goto(page.resolve().as_uri())
        tab.wait_for_selector("[data-ready=yes]", timeout=120_000)
        yield tab
        assert said == []
        browser.close()


def until(true, seconds=30.0):
    """Wait for what a page does by itself, asking a hundred times a second."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.01)


def canvas(tab):
    """Picture (height, width, 3) of the canvas as it stands, without what lies over it."""
    tab.wait_for_timeout(400)  # a picture is drawn when the browser next shows one
    data = tab.evaluate("document.querySelector('canvas').toDataURL('image/png')")
    return imageio.imread(base64.b64decode(data.split(",")[1]))[..., :3].astype(int)


def changed(one, other):
    """Share of the pixels that differ."""
    return float((np.abs(one - other).max(axis=-1) > 12).mean())


def snowy(picture):
    """Where the picture is near white."""
    return picture.min(axis=-1) > 215


def white(picture):
    """Where it is so without the blue of the sky near the horizon."""
    return (picture.min(axis=-1) > 195) & (picture[..., 2] - picture[..., 0] < 13)


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


@pytest.fixture(scope="module")
def space(tmp_path_factory):
    """The page of a slab in space."""
    folder = tmp_path_factory.mktemp("space")
    slab_3d(folder / "run", frames=5, obstacles=True)
    return render_page(folder / "run", folder / "scene.html", camera="150,35")


def test_turn_play_change_field_map_and_cut(space, tmp_path):
    with opened(space, tmp_path) as tab:
        first = canvas(tab)
        assert changed(first, canvas(tab)) == 0.0
        tab.mouse.move(400, 250)
        tab.mouse.down()
        tab.mouse.move(520, 230, steps=3)
        tab.mouse.up()
        turned = canvas(tab)
        assert changed(first, turned) > 0.2
        tab.click("button[title='first view']")
        assert changed(first, canvas(tab)) == 0.0
        # Played from the end it begins anew: the snow lies higher, fast snow has warm colours
        tab.click("button[title=play]")
        until(lambda: tab.input_value("input[aria-label=time]") == "2")
        tab.click("button[title=play]")
        tab.locator("input[aria-label=time]").fill("2")
        moving = canvas(tab)
        assert "t = 4.00 s" in tab.inner_text(".clock") and warm(moving).sum() > 200
        tab.select_option("select[aria-label='colour of the snow']", label="density [kg/m3]")
        dense = canvas(tab)
        assert 0.001 < changed(moving, dense) < 0.3 and "density" in tab.inner_text(".legend")
        tab.select_option("select[aria-label='colour of the snow']", label="plain snow")
        plain = canvas(tab)
        assert white(plain).sum() > white(moving).sum() and warm(plain).sum() < 0.1 * warm(moving).sum()
        tab.select_option("select[aria-label='map on the ground']", index=1)
        mapped = canvas(tab)
        assert changed(plain, mapped) > 0.02 and tab.locator(".legend").count() == 1
        # Only what is deeper than all of it is as dark as the low end: the ends of the scale can be set
        tab.click("input[aria-label^=lowest]", click_count=3)
        tab.keyboard.type("1.9")
        tab.keyboard.press("Enter")
        assert changed(mapped, canvas(tab)) > 0.01
        tab.select_option("select[aria-label=cut]", label="cut across x")
        half = canvas(tab)
        sky = (half[..., 2] > half[..., 0] + 10).mean() - (plain[..., 2] > plain[..., 0] + 10).mean()
        assert sky > 0.1  # of the ground nearer than the plane nothing is left
        tab.click("button[title^=other]")
        assert changed(half, canvas(tab)) > 0.2


def test_measure_by_two_taps(space, tmp_path):
    with opened(space, tmp_path) as tab:
        tab.click("button[title^=measure]")
        until(lambda: "Tap two places" in tab.inner_text(".said"))
        tab.mouse.click(450, 300)
        tab.mouse.click(520, 340)
        until(lambda: "slope" in tab.inner_text(".said"))
        words = tab.inner_text(".said")
        assert re.search(r"\d+\.\d m, \d+\.\d m in plan, -?\d+\.\d m up, slope -?\d+\.\d°, bearing \d+°", words)
        assert tab.locator(".viewer circle").count() == 2
        place = tab.locator(".viewer circle").last.bounding_box()
        assert abs(place["x"] + place["width"] / 2 - 520) < 3 and abs(place["y"] + place["height"] / 2 - 340) < 3


def test_on_a_phone_all_is_within_reach_of_a_finger(space, tmp_path):
    size = (390, 780)
    with opened(space, tmp_path, size, touch=True) as tab:
        assert tab.evaluate("document.documentElement.scrollWidth") <= size[0]
        for one in tab.locator(".bar button, .bar select, canvas").all():
            box = one.bounding_box()
            if box is None:
                continue  # of the cut, while there is none
            assert box["height"] >= 44 and box["x"] >= 0 and box["x"] + box["width"] <= size[0]
            assert box["y"] + box["height"] <= size[1]
        first = canvas(tab)
        assert white(first).sum() > 100
        fingers = tab.context.new_cdp_session(tab)
        for kind, apart in (("touchStart", 110), ("touchMove", 80), ("touchMove", 40)):
            points = [{"x": 195 - apart, "y": 300, "id": 0}, {"x": 195 + apart, "y": 300, "id": 1}]
            fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        assert white(canvas(tab)).sum() < 0.6 * white(first).sum()  # two fingers together: farther


def test_page_of_a_crack_shows_it(tmp_path):
    weak_layer_3d(tmp_path / "run")
    picture, document = screenshot(render_page(tmp_path / "run", tmp_path / "scene.html", color="fracture"), (900, 600),
                                   tmp_path)
    assert 'data-ready="yes"' in document
    assert warm(picture[60:480, :640]).sum() > 30  # the broken weak layer, at the sides of the slab


def test_report_shows_pictures_scene_and_curves(tmp_path):
    weak_layer_3d(tmp_path / "run")
    page = render_report(tmp_path / "run", tmp_path / "report.html", size=(640, 320))
    with opened(page, tmp_path, (1200, 4200)) as tab:
        assert "How to make it again" in tab.content()
        picture = imageio.imread(tab.screenshot())[..., :3].astype(int)
    assert picture.shape == (4200, 1200, 3)
    rows = picture.std(axis=(1, 2))
    assert (rows > 25.0).mean() > 0.4  # pictures fill the page
    assert warm(picture).sum() > 2000  # the crack in the cutaway
    assert np.ptp(picture[:60].reshape(-1, 3), axis=0).min() > 150  # the heading, dark on light

"""`run --live`: a page with the newest picture, drawn beside the steps."""

import base64
import io
import re
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from snowmpm.cli.live import Live
from snowmpm.io import RunWriter
from snowmpm.render import live
from snowmpm.running.loop import Progress

BLOCK = Path(__file__).with_name("block.toml")


def picture_in(page):
    """The picture (height, width, 3) of a page."""
    found = re.search(r'src="data:image/jpeg;base64,([^"]+)"', page)
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(found[1]))))


def test_page_keeps_the_last_picture_of_a_run(call, tmp_path):
    result = call("run", BLOCK, "-o", "run", "--live", "pages/live.html", "-q")
    assert result.code == 0, result.err
    page = (tmp_path / "pages" / "live.html").read_text()
    assert 'http-equiv="refresh"' not in page
    assert "The run has ended" in page and "0.020 of 0.02 s (100%)" in page and "t = 0.02 s" in page
    picture = picture_in(page)
    assert picture.shape == (*live.SIZE[::-1], 3)
    assert (picture.min(axis=-1) > 215).sum() > 500  # snow


def test_pages_that_cannot_be_are_refused_before_the_run(call):
    for page, why in (("live.txt", "must end in .html"), (f"{BLOCK}/live.html", "must be a folder")):
        result = call("run", BLOCK, "-o", "run", "--live", page)
        assert result.code == 2 and why in result.err and not Path("run").exists()


class Said:
    """News of a run that ends at the k-th look; waits: how long each look waited."""

    def __init__(self, looks):
        self.rows, self.ended, self.waits, self._looks = {"time": "now"}, self, [], looks

    def wait(self, seconds):
        self.waits.append(seconds)
        return len(self.waits) >= self._looks


def test_picture_follows_the_run_file(tmp_path):
    square = np.stack(np.meshgrid(np.arange(8.0), np.arange(8.0)), axis=-1).reshape(-1, 2)
    picture, news, pages = live.LivePicture(tmp_path), Said(2), []
    with RunWriter(tmp_path, provenance={}, dimension=2, terrain=None) as writer:
        for k in range(3):
            writer.frame(0.5 * k, square + np.array([3.0 * k, 0.0]), {"velocity": np.ones_like(square)})
            picture.look()
            pages.append(live.live_page("moving", picture, news, ended=False))
            before = picture.jpeg
            picture.look()
            assert picture.jpeg is before  # no new frame: nothing is drawn
    assert [re.search("t = ([0-9.]+) s", page)[1] for page in pages] == ["0", "0.5", "1"]
    assert all(f'http-equiv="refresh" content="{live.RELOAD}"' in page for page in pages)
    assert np.abs(picture_in(pages[1]).astype(int) - picture_in(pages[2])).max() > 50


def test_drawing_takes_its_share_of_the_time_and_no_more(tmp_path, monkeypatch):
    def look(picture, ended=False):
        begun = time.process_time()
        while time.process_time() - begun < 0.06:
            pass

    monkeypatch.setattr(live.LivePicture, "look", look)
    news = Said(3)
    live.draw_while_running(tmp_path, tmp_path / "live.html", "busy", news)
    assert news.waits[0] == 0.0 and all(wait >= 0.06 / live.SHARE for wait in news.waits[1:])


def test_run_goes_on_when_its_page_dies(tmp_path):
    page = Live(tmp_path / "live.html", tmp_path, "killed")
    page.begin()
    page._process.kill()
    page._process.wait()
    for _ in range(3):
        page(Progress(time=0.5, end_time=1.0, front=float("nan")))
        page._due = 0.0
    assert not page.end()


@pytest.mark.parametrize("trouble", [ValueError, OSError])
def test_news_end_with_the_pipe(trouble):
    def lines():
        yield '{"time": "1 s"}\n'
        raise trouble

    news = live.News(lines())
    assert news.ended.wait(10.0) and news.rows == {"time": "1 s"}

"""A page with the newest picture of a run that goes on, drawn in a process of its own beside the steps.

The process that computes starts it and tells it the numbers of the run, one line of JSON a time; the pictures come from
the run file. It ends when that pipe is closed, however the other process ended.
"""

import contextlib
import io
import json
import os
import sys
import threading
import time as clock

from PIL import Image

from snowmpm import overwriting
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.status import status_of
from snowmpm.render.page import encoded, escaped, note, numbers, page, write_page
from snowmpm.render.run_film import view_of

SIZE = (960, 540)
SHARE = 0.02
"""Processor time of drawing over the time that passes, of one core: a longer drawing is followed by a longer pause."""

LEAST = 1.0
"""Seconds between two pictures at least."""

RELOAD = 2
"""Seconds after which the browser opens the page again."""

QUALITY = 88  # of the picture as JPEG
WAITING = "The first picture comes with the first step."


class News:
    """What the run says of itself: rows {name: text} of the last line, None before the first; ended: no more comes."""

    def __init__(self, stream):
        self.rows, self.ended = None, threading.Event()
        threading.Thread(target=self._listen, args=(stream,), daemon=True).start()

    def _listen(self, stream):
        # Lines that nobody reads would fill the pipe, and the run would wait
        with contextlib.suppress(OSError, ValueError):
            for line in stream:
                self.rows = json.loads(line)
        self.ended.set()


class LivePicture:
    """The newest frame of a run in `folder`, with camera and colours as the run so far asks for."""

    def __init__(self, folder, size=SIZE):
        self._folder, self._size = folder, size
        self._run, self._frames, self.jpeg, self.time = None, 0, None, None

    def look(self, ended=False):
        """Draw the newest frame, if there is one that was not drawn; ended: what is not final is written on it."""
        if self._run is None:
            self._run = Run(self._folder)
        self._run.refresh()
        frames = len(self._run)
        if not frames or (frames == self._frames and not ended):
            return
        view = view_of(self._run, self._size)
        if not ended:
            view.cautions = ()  # a run that goes on is never complete
        picture, data = view.picture(frames - 1), io.BytesIO()
        Image.fromarray(picture).save(data, "JPEG", quality=QUALITY)
        self._frames, self.jpeg, self.time = frames, data.getvalue(), float(self._run.times[-1])

    @property
    def status(self):
        """How the run ended, in words."""
        return None if self._run is None else status_of(self._run)


def live_page(title, picture, news, ended, trouble=None):
    """HTML of the page. picture: `LivePicture`; trouble: why there is no newer one."""
    parts = [f"<h1>{escaped(title.replace('_', ' '))}</h1>"]
    if ended:
        status = picture.status
        final = status is not None and status.final
        words = "it ended before its first frame" if status is None else status.text
        parts.append(note(f"The run has ended; {words}", "good" if final else "warning"))
    elif news.rows is None:
        parts.append(note(WAITING, "good"))
    if trouble:
        parts.append(note(trouble))
    if picture.jpeg:
        drawn = f"t = {picture.time:.6g} s, drawn at {clock.strftime('%H:%M:%S')}"
        parts.append(f'<figure><img alt="{escaped(drawn)}" src="data:image/jpeg;base64,{encoded(picture.jpeg)}">'
                     f"<figcaption>{escaped(drawn)}</figcaption></figure>")
    parts += [numbers(news.rows)] if news.rows else []
    return page(title, "\n".join(parts), refresh=None if ended else RELOAD)


def draw_while_running(folder, file, title, news):
    """Keep the page `file` up to date with the run in `folder` until it has ended; the last picture stays."""
    picture, pause, ended = LivePicture(folder), 0.0, False
    while not ended:
        ended = news.ended.wait(pause)
        began, trouble = clock.process_time(), None
        if news.rows is not None:  # before the first step, the folder may still hold an older run
            try:
                picture.look(ended)
            except (InputError, OSError, MemoryError) as error:
                trouble = f"No newer picture: {error}"
        # A disk that is full now may have room later
        with contextlib.suppress(OSError):
            write_page(file, live_page(title, picture, news, ended, trouble))
        pause = max(LEAST, (clock.process_time() - began) / SHARE)


def main():
    """What the process runs: sys.argv[1:] are the folder of the run, the page and the title."""
    with contextlib.suppress(OSError, AttributeError):  # not on Windows
        os.nice(10)
    with overwriting.keeping(overwrite=True):  # the command has asked; the page is to be known as its own
        draw_while_running(*sys.argv[1:4], News(sys.stdin))

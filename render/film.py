"""Pictures into a file: MP4, GIF, one PNG or a folder of them. An unfinished file never carries the final name.

A film that is interrupted is kept as FILM.unfinished.mp4 or .gif, as far as it has come.
"""

import io
import re
from contextlib import contextmanager
from pathlib import Path

import imageio.v2 as imageio
import numpy as np
from PIL import Image

from snowmpm import overwriting
from snowmpm.draft import draft
from snowmpm.errors import InputError, shown_line
from snowmpm.render.mp4 import film_so_far, open_mp4, unfinished

FILMS = (".mp4", ".gif")
PICTURES = (".png", ".tif")
FRAME = re.compile(r"frame_(\d{5,})\.(png|tif)")


def output_kind(output):
    """ ".mp4", ".gif", ".png", ".tif" or "" for a folder. Raises InputError for another ending."""
    kind = Path(output).suffix.lower()
    if kind not in (*FILMS, *PICTURES, ""):
        raise InputError.at("output", str(output), "must end in .mp4, .gif, .png or .html, or be a folder")
    return kind


@contextmanager
def open_film(output, fps):
    """A function that takes one picture after the other, (height, width, 3 or 4) uint8 or, of numbers, (height, width)
    float32; the file appears at the end.

    Raises InputError for a folder that holds other files, OSError when it cannot be written, and KeyboardInterrupt that
    names what was kept of a film.
    """
    path, kind = Path(output), output_kind(output)
    if kind == "":
        with _open_folder(path) as show:
            yield show
    elif kind in PICTURES:
        yield lambda picture: _write_picture(picture, path)
    elif kind == ".gif":
        with _open_gif(path, fps) as show:
            yield show
    else:
        with open_mp4(path, fps) as show:
            yield show


@contextmanager
def _open_folder(path):
    """One PNG or TIFF a picture; those of a longer film that was drawn there before are taken away at the end."""
    path.mkdir(parents=True, exist_ok=True)
    others = sorted(file.name for file in path.iterdir()
                    if not FRAME.fullmatch(file.name) and file.name != overwriting.LIST)
    if others:
        named = ", ".join([*map(shown_line, others[:3]), *["..."] * (len(others) > 3)])
        raise InputError(f"{path}: holds other files ({named}): name a folder of its own for the pictures, or"
                         " a .mp4, .gif or .png file in it")
    count = 0

    def show(picture):
        nonlocal count
        _write_picture(picture, path / f"frame_{count:05d}{'.tif' if picture.dtype == np.float32 else '.png'}")
        count += 1

    yield show
    for file in path.iterdir():
        found = FRAME.fullmatch(file.name)
        if found and int(found[1]) >= count:
            file.unlink()


@contextmanager
def _open_gif(path, fps):
    """As `open_mp4`; but what is drawn lies in memory until the end, and is lost when the program is killed."""
    # imageio has all pictures in memory anyway, and leaves a traceback where it cannot write them
    film, pictures = io.BytesIO(), 0

    def show(picture):
        nonlocal pictures
        writer.append_data(picture)
        pictures += 1

    try:
        with imageio.get_writer(film, format="GIF", mode="I", duration=1000.0 / fps, loop=0) as writer:
            yield show
    except KeyboardInterrupt as interruption:
        if not pictures:
            raise
        with draft(unfinished(path)) as part:
            part.write_bytes(film.getbuffer())
        raise film_so_far(unfinished(path), pictures) from interruption
    with draft(path) as part:
        part.write_bytes(film.getbuffer())


def _write_picture(picture, path):
    with draft(path) as part:
        Image.fromarray(picture).save(part)

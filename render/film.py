"""Pictures into a file: MP4, GIF, one PNG or a folder of them. An unfinished file never carries the final name."""

import io
import struct
from contextlib import contextmanager
from pathlib import Path

import imageio.v2 as imageio
from PIL import Image

from snowmpm.draft import draft
from snowmpm.errors import InputError

FILMS = (".mp4", ".gif")
QUALITY = "20"  # of H.264: constant rate factor, 18 is visually lossless


def output_kind(output):
    """ ".mp4", ".gif", ".png" or "" for a folder. Raises InputError for another ending."""
    kind = Path(output).suffix.lower()
    if kind not in (*FILMS, ".png", ""):
        raise InputError.at("output", str(output), "must end in .mp4, .gif, .png or .html, or be a folder")
    return kind


@contextmanager
def open_film(output, fps):
    """A function that takes one picture (height, width, 3) uint8 after the other; the file appears at the end.

    Raises OSError when it cannot be written.
    """
    path, kind = Path(output), output_kind(output)
    if kind == "":
        path.mkdir(parents=True, exist_ok=True)
        count = iter(range(10**9))
        yield lambda picture: _write_picture(picture, path / f"frame_{next(count):05d}.png")
    elif kind == ".png":
        yield lambda picture: _write_picture(picture, path)
    elif kind == ".gif":
        # In memory: imageio has all pictures there anyway, and leaves a traceback where it cannot write them
        film = io.BytesIO()
        with imageio.get_writer(film, format="GIF", mode="I", duration=1000.0 / fps, loop=0) as writer:
            yield writer.append_data
        with draft(path) as part:
            part.write_bytes(film.getbuffer())
    else:
        with draft(path) as part:
            with _encoder(part, fps) as writer:
                yield writer.append_data
            if not _is_whole(part):
                raise OSError("ffmpeg left it unfinished")


def _write_picture(picture, path):
    with draft(path) as part:
        Image.fromarray(picture).save(part)


def _encoder(path, fps):
    options = ["-crf", QUALITY, "-preset", "medium", "-movflags", "+faststart"]
    return imageio.get_writer(
        path,
        format="FFMPEG",
        mode="I",
        fps=fps,
        codec="libx264",
        pixelformat="yuv420p",
        macro_block_size=2,
        output_params=options,
        ffmpeg_log_level="quiet",
    )


def _is_whole(path):
    """Whether the boxes of an MP4 file, each a length and a name, fill it to the end, the index among them.

    ffmpeg's end is not looked at by imageio: on a full disk it leaves a file that no player opens.
    """
    size, at, names = path.stat().st_size, 0, set()
    with open(path, "rb") as file:
        while at + 8 <= size:
            file.seek(at)
            length, name = struct.unpack(">I4s", file.read(8))
            if length == 1:
                length = int.from_bytes(file.read(8), "big")
            names.add(name)
            at += max(length, 8) if length else size - at
    return at == size and {b"moov", b"mdat"} <= names

"""Pictures into a file: MP4, GIF, one PNG or a folder of them. An unfinished file never carries the final name."""

import os
from contextlib import contextmanager
from pathlib import Path

import imageio.v2 as imageio

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
    """A function that takes one picture (height, width, 3) uint8 after the other; the file appears at the end."""
    path, kind = Path(output), output_kind(output)
    if kind == "":
        path.mkdir(parents=True, exist_ok=True)
        count = iter(range(10**9))
        yield lambda picture: imageio.imwrite(path / f"frame_{next(count):05d}.png", picture)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.stem}.unfinished{kind}")
    try:
        if kind == ".png":
            yield lambda picture: imageio.imwrite(draft, picture)
        else:
            with _writer(draft, kind, fps) as writer:
                yield writer.append_data
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)


def _writer(path, kind, fps):
    if kind == ".gif":
        return imageio.get_writer(path, mode="I", duration=1000.0 / fps, loop=0)
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
        ffmpeg_log_level="error",
    )

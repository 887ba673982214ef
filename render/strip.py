"""Moments of a run one below the other in one picture, which knows where it came from."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from snowmpm.annotations import PathLike
from snowmpm.draft import draft
from snowmpm.errors import InputError, shown_line
from snowmpm.io import Run
from snowmpm.render.run_film import nearest_frame, view_of
from snowmpm.stages import counted

GAP = 6  # px of white between two moments


def render_strip(run: Run, output: PathLike, *, times: Iterable[float] | None = None, color: str | None = None,
                 camera: str | None = None, size: tuple[int, int] = (1280, 480), inset: str = "auto",
                 plots: Sequence[Callable[[Run, Path], object]] = (),
                 notes: Mapping[str, object] | None = None) -> Path:
    """Draw the frames of a `snowmpm.io.Run` nearest to `times` [s] (by default its last) to a PNG; -> its path.

    color, camera, size, inset as `render_run` takes them. plots: functions (run, file) that draw a PNG each, put below.
    notes: texts by name that go into the file and come back by `notes_of`. Errors as of `render_run`.
    """
    path = Path(output)
    if path.suffix.lower() != ".png":
        raise InputError.at("output", str(output), "must end in .png")
    view = view_of(run, tuple(size), color, camera, inset=inset)
    chosen = dict.fromkeys([len(run) - 1] if times is None else [nearest_frame(run, time) for time in times])
    pictures = [Image.fromarray(view.picture(i)) for i in counted(chosen, "drawing", "pictures")]
    with draft(path) as part:
        for plot in plots:
            plot(run, part)
            with Image.open(part) as drawn:
                pictures.append(_as_wide(drawn.convert("RGB"), size[0]))
        _below_each_other(pictures).save(part, pnginfo=_text(notes or {}), optimize=True)
    return path


def notes_of(path: PathLike) -> dict[str, str]:
    """The notes that `render_strip` put into a picture. Raises InputError for what is no readable picture."""
    try:
        with Image.open(path) as picture:
            return dict(getattr(picture, "text", {}))
    except Exception as error:  # damaged files fail in Pillow in a dozen ways
        raise InputError(f"{path}: not a readable picture ({shown_line(error, 100)})") from None


def _text(notes: Mapping[str, object]) -> PngInfo:
    text = PngInfo()
    for name, value in notes.items():
        text.add_itxt(name, str(value))
    return text


def _as_wide(picture: Image.Image, width: int) -> Image.Image:
    return picture.resize((width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS)


def _below_each_other(pictures: Sequence[Image.Image]) -> Image.Image:
    width = max(picture.width for picture in pictures)
    height = sum(picture.height for picture in pictures) + GAP * (len(pictures) - 1)
    whole, top = np.full((height, width, 3), 255, np.uint8), 0
    for picture in pictures:
        whole[top : top + picture.height, : picture.width] = np.asarray(picture)
        top += picture.height + GAP
    return Image.fromarray(whole)

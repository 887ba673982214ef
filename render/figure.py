"""Matplotlib figures: how their panels look, and how they become files."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike
from PIL import Image

from snowmpm.annotations import PathLike
from snowmpm.draft import draft
from snowmpm.errors import InputError

ENDINGS = (".png", ".pdf", ".svg")
INK = "#11161c"
"""Colour of titles, and of what is known from elsewhere."""

PAD = 0.15
"""Inches around what is drawn."""

COMPRESSION = 3
"""Level of zlib: half the time of 6, and files a tenth larger."""

DASHES = ("-", (0, (5, 1.6)), (0, (1.2, 1.2)), (0, (5, 1.2, 1, 1.2)))
"""Line styles of what a panel shows beside each other of one run."""


def check_ending(output: PathLike) -> None:
    """Raises InputError unless `output` ends in one of ENDINGS."""
    if Path(output).suffix.lower() not in ENDINGS:
        raise InputError.at("output", str(output), f"must end in {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}")


def plain(axes: Axes) -> None:
    """The look of a panel: two spines, a faint grid, few numbers."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.92", lw=0.7)
    axes.set_axisbelow(True)
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.tick_params(labelsize=9, color="0.5")


def titled(axes: Axes, title: str, x: str, y: str) -> None:
    """Title of a panel, and labels of its axes."""
    axes.set_title(title, loc="left", fontsize=10)
    axes.set_xlabel(x)
    axes.set_ylabel(y)


def prefixed(*values: ArrayLike, unit: str = "Pa") -> tuple[float, str]:
    """Power of 1000 that suits the largest value, and the unit with its prefix."""
    largest = max((float(np.nanmax(np.abs(v), initial=0.0)) for v in values), default=0.0)
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if largest >= factor:
            return factor, prefix + unit
    return 1.0, unit


def save(figure: Figure, output: PathLike, dpi: float) -> Path:
    """Draw `figure` to `output`, which is there complete or not at all. Returns its path."""
    path = Path(output)
    take_literally(figure)
    canvas = FigureCanvasAgg(figure)
    if path.suffix.lower() == ".png":
        return save_picture(_pixels(canvas, dpi), path, dpi)
    with draft(path) as part:
        canvas.print_figure(part, dpi=dpi, bbox_inches="tight", pad_inches=PAD)
    return path


def save_picture(picture: Image.Image, output: PathLike, dpi: float) -> Path:
    """Write a picture as a PNG, which is there complete or not at all. Returns its path."""
    with draft(Path(output)) as part:
        picture.save(part, "PNG", compress_level=COMPRESSION, dpi=(dpi, dpi))
    return Path(output)


def _pixels(canvas, dpi):
    """Picture of a figure without its empty margin: what bbox_inches="tight" gives, but laid out and drawn once."""
    figure = canvas.figure
    figure.set_dpi(dpi)
    canvas.draw()
    figure.set_layout_engine("none")
    picture = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3])
    return framed(picture, figure.get_tightbbox(canvas.get_renderer()), dpi)


def framed(picture: Image.Image, used: Bbox, dpi: float) -> Image.Image:
    """The part of a picture of a figure that is used, a box in inches, with a margin of PAD."""
    box, rows = used.padded(PAD), picture.height
    left, right = int(np.floor(box.x0 * dpi)), int(np.ceil(box.x1 * dpi))
    top, bottom = rows - int(np.ceil(box.y1 * dpi)), rows - int(np.floor(box.y0 * dpi))
    found = Image.new("RGB", (right - left, bottom - top), "white")
    found.paste(picture, (-left, -top))
    return found


def take_literally(figure: Figure) -> None:
    """Show dollar signs in titles, labels and legends as they are: names come from files, and would be read as
    formulas. Numbers along the axes keep their powers of ten."""
    axes_of = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    # By the method: the lists of ticks hold those of the last drawing, which for logarithms are too few
    numbers = {label for axis in axes_of for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks())
               for label in (tick.label1, tick.label2)} | {axis.get_offset_text() for axis in axes_of}
    for text in figure.findobj(Text):
        if text not in numbers:
            text.set_parse_math(False)

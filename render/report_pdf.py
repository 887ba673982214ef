"""A report as a PDF on A4: the blocks of a `snowmpm.render.document.Document`, one below the other."""

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from PIL import Image

from snowmpm.annotations import PathLike
from snowmpm.draft import draft
from snowmpm.render import document as content
from snowmpm.render.document import Document

PAPER = (8.27, 11.69)  # inches
MARGIN, FOOT = 0.75, 0.65
WIDTH = PAPER[0] - 2 * MARGIN
INK, FAINT, WARNING, GOOD = "#18222e", "#5d6b7a", "#c1121f", "#1f5fa8"
DPI = 160
LARGEST = 4.6  # inches: height of a picture; two fit on a page


def write_pdf(document: Document, output: PathLike) -> Path:
    """Write a `Document` as a PDF; -> its path, which is there complete or not at all."""
    path = Path(output)
    with draft(path) as part, PdfPages(part, metadata={"Title": document.title, "Creator": "snowmpm"}) as pages:
        sheet = _Sheet(pages, document.title)
        sheet.text(document.title, 20, bold=True, after=0.04)
        sheet.text(document.lead, 9.5, FAINT, after=0.12)
        for section in document.sections:
            if section.title and section.blocks:
                sheet.heading(section.title, _first_height(section.blocks[0]))
            for block in section.blocks:
                _draw(sheet, block)
        sheet.text(document.foot, 8, FAINT)
        sheet.finish()
    return path


def _draw(sheet, block):
    match block:
        case content.Numbers(rows):
            sheet.table(rows, 12)
        case content.Note(text, kind):
            sheet.text(text, 9.5, GOOD if kind == "good" else WARNING, bold=kind != "good")
        case content.Paragraph(text):
            sheet.text(text, 9, FAINT)
        case content.Picture(path, words):
            sheet.picture(path, words)
        case content.Columns(pictures):
            for one in pictures:
                sheet.picture(one.path, one.words)
        case content.Table(rows):
            sheet.table(rows)
        case content.Listing(text, summary):
            sheet.text(summary or "", 9, FAINT)
            sheet.listing(text)
        case content.Definitions(quantities):
            for one in quantities:
                sheet.text(f"{one.label}:  {one.definition}", 8, after=0.03)
        case content.Live(_, words):
            sheet.text(words, 9, FAINT)
        case _:
            raise TypeError(f"not a block of a document: {type(block).__name__}")


def _fitted(image):
    """Width and height of a picture on the page: as wide as the page, or as high as LARGEST."""
    height = WIDTH * image.height / image.width
    return (WIDTH, height) if height <= LARGEST else (WIDTH * LARGEST / height, LARGEST)


def _first_height(block):
    """Height that the first part of a block needs."""
    match block:
        case content.Picture(path) | content.Columns((content.Picture(path), *_)):
            with Image.open(path) as image:
                return _fitted(image)[1] + 0.35
    return 1.0


class _Sheet:
    """Pages filled from top to bottom; lengths in inches."""

    def __init__(self, pages, title):
        self._pages, self._title, self._number, self._figure = pages, title, 0, None
        self._next()

    def _next(self):
        self.finish()
        self._figure, self._y = Figure(figsize=PAPER, dpi=DPI), PAPER[1] - MARGIN
        self._number += 1
        self._write(MARGIN, 0.4, self._title, 8, FAINT)
        self._write(PAPER[0] - MARGIN, 0.4, str(self._number), 8, FAINT, align="right")

    def finish(self):
        """Put the page away."""
        if self._figure is not None:
            self._pages.savefig(self._figure)
            self._figure = None

    def _room(self, height):
        """Go to the next page unless there is room for `height`."""
        if self._y - height < FOOT:
            self._next()

    def _write(self, x, y, text, size, colour=INK, bold=False, mono=False, align="left"):
        # Names and scene texts may hold a dollar sign, which is no mathematics here
        self._figure.text(x / PAPER[0], y / PAPER[1], text, fontsize=size, color=colour, ha=align, va="baseline",
                          fontweight="bold" if bold else "normal", parse_math=False,
                          family="DejaVu Sans Mono" if mono else "DejaVu Sans")

    def text(self, words, size, colour=INK, bold=False, after=0.08):
        """Lines of text, wrapped."""
        for line in textwrap.wrap(_printable(words), round(WIDTH * (118.0 if bold else 126.0) / size)):
            self._room(size / 55.0)
            self._y -= size / 55.0
            self._write(MARGIN, self._y, line, size, colour, bold)
        self._y -= after if words else 0.0

    def heading(self, words, below):
        """A heading, on the page of what is below it, of this height."""
        self._room(0.6 + below)
        self._y -= 0.12
        self.text(words, 14, bold=True)

    def table(self, rows, size=8.5):
        """Names and values in two columns."""
        left = 0.46 * WIDTH
        for name, value in rows.items():
            names = textwrap.wrap(_printable(name), round(left * 126.0 / size)) or [""]
            values = textwrap.wrap(_printable(value), round((WIDTH - left) * 126.0 / size)) or [""]
            height = max(len(names), len(values)) * size / 52.0
            self._room(height)
            for k, line in enumerate(names):
                self._write(MARGIN, self._y - (k + 1) * size / 52.0, line, size, FAINT)
            for k, line in enumerate(values):
                self._write(MARGIN + left, self._y - (k + 1) * size / 52.0, line, size)
            self._y -= height
        self._y -= 0.1

    def listing(self, text):
        """Text as it is, small."""
        for line in text.splitlines():
            for row in textwrap.wrap(_printable(line), 105, subsequent_indent="    ", drop_whitespace=False) or [""]:
                self._room(0.125)
                self._y -= 0.125
                self._write(MARGIN, self._y, row, 7, mono=True)
        self._y -= 0.1

    def picture(self, path, words):
        """A picture, as wide as the page or as high as LARGEST, with its words."""
        with Image.open(path) as image:
            width, height = _fitted(image)
            shown = image.convert("RGB")
            shown.thumbnail((round(DPI * width), round(DPI * height)), Image.Resampling.LANCZOS, reducing_gap=2.0)
            pixels = np.asarray(shown)
        self._room(height + 0.35)
        self._y -= height
        axes = self._figure.add_axes([0.5 - 0.5 * width / PAPER[0], self._y / PAPER[1], width / PAPER[0],
                                      height / PAPER[1]])
        axes.imshow(pixels, interpolation="none")  # as it is: Matplotlib would fit it to the pixels of the page again
        axes.set_axis_off()
        self.text(words, 8, FAINT, after=0.12)


def _printable(text):
    """Text without control characters, which fonts do not hold."""
    return "".join(letter if letter.isprintable() else " " for letter in str(text))

"""ESRI ASCII grids (.asc), by a parser of our own."""

import codecs
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget

HEADER = ("ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value")
WORDS_FOR_NONE = ("null", "none", "na", "n/a", "nodata", "*", "-")
"""What programs write in cells without a value in place of a number, and declare so."""

NONE = "word for none"
"""Such a word of a head."""

LARGEST_SURE = 1e30
"""Beyond it, a number for "none" may be rounded in the head or in the cells."""

LARGEST_COUNT = 2**31
"""Columns or rows that a header may promise."""

TEXT_BYTES, CELL_BYTES = 3.0, 200.0
"""Memory while it is read: over a byte of the file, and over a cell that is kept."""


def read_grid(path, key, window):
    """Centres x (nx,), y (ny,) and heights z (ny, nx) as they are in the file, all ascending; NaN for no data.

    The header is lines of a keyword and a value, then rows from north to south; registered by centres or corners.
    window: function (x, y) -> slices of the columns and rows to keep, or a refusal. InputError: no such grid.
    """
    where = f"{key} = {str(path)!r}"
    try:
        size = Path(path).stat().st_size
        read_budget.allow(where, TEXT_BYTES * size, "its text")
        lines = _text(Path(path).read_bytes()).splitlines()
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise InputError.at(key, str(path), "is not an ESRI ASCII grid (not plain text)") from error
    head, first = _header(lines, path, key)
    x, y = _centres(head, size, path, key)
    columns, rows = window(x, y)
    nx, ny = len(x), len(y)
    body = [line for line in lines[first:] if line.strip()]
    # One line a row, as the format says, though it does not ask for it: only the rows of the window are parsed
    if len(body) == ny and all(len(line.split()) == nx for line in body):
        body = body[ny - rows.stop : ny - rows.start]
        kept = rows.stop - rows.start
    else:
        kept = ny
    read_budget.allow(where, TEXT_BYTES * size + CELL_BYTES * kept * nx, f"{kept} x {nx} cells",
                      "terrain.region or domain cut it")
    words = " ".join(body).split()
    if (none := head.get(NONE)) is not None:
        words = ["nan" if word.lower() == none else word for word in words]
    try:
        z = np.array(words, dtype=float)
    except ValueError as error:
        raise InputError.at(key, str(path), f"holds something that is not a number ({str(error)[:80]})") from None
    if z.size != kept * nx:
        raise InputError.at(key, str(path), f"holds {z.size} values where its header promises {kept * nx}")
    z = z.reshape(kept, nx)[::-1]
    z = z[:, columns] if kept < ny else z[rows, columns]
    return x[columns], y[rows], np.where(_is_none(z, head.get("nodata_value", -9999.0)) | ~np.isfinite(z), np.nan, z)


def _text(data):
    """ASCII, or what a byte order mark says. Raises UnicodeDecodeError."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16")
    return data.removeprefix(codecs.BOM_UTF8).decode("ascii")


def _is_none(z, none):
    """Whether values are the number for "none"; that of the ends of single precision, as it may be rounded."""
    same = z == none
    if LARGEST_SURE < abs(none) < np.inf:
        same |= (np.abs(z) > LARGEST_SURE) & (np.abs(z / none - 1.0) < 1e-3)
    return same


def _header(lines, path, key):
    """Values by keyword, and the number of the first line behind them."""
    head = {}
    for n, line in enumerate(lines):
        words = line.split(maxsplit=2)
        if words and words[0].lower() not in HEADER:
            return head, n
        if words:
            name = words[0].lower()
            try:
                if name == "nodata_value" and len(words) == 2 and words[1].lower() in WORDS_FOR_NONE:
                    head[NONE] = words[1].lower()
                    continue
                if len(words) > 2:
                    raise ValueError
                head[name] = float(words[1])
            except (IndexError, ValueError):
                raise InputError.at(key, str(path), f"line {n + 1}: {line.strip()[:60]!r} needs one number") from None
    return head, len(lines)


def _centres(head, size, path, key):
    """Centres of the columns and rows that a header promises, in a file of `size` bytes."""
    try:
        counts = [head["ncols"], head["nrows"]]
        dx, dy = (head[k] if k in head else head["cellsize"] for k in ("dx", "dy"))
        x0, y0 = (
            head[f"{a}llcenter"] if f"{a}llcenter" in head else head[f"{a}llcorner"] + 0.5 * step
            for a, step in (("x", dx), ("y", dy))
        )
    except KeyError as error:
        missing = f"is not an ESRI ASCII grid: header line {error.args[0]!r} is missing"
        raise InputError.at(key, str(path), missing) from None
    if not all(1 <= n <= LARGEST_COUNT and n == int(n) for n in counts) or not (0 < dx < np.inf and 0 < dy < np.inf):
        raise InputError.at(key, str(path), "header must have positive ncols, nrows and cellsize, the first two whole")
    if not np.isfinite([x0, y0]).all():
        raise InputError.at(key, str(path), "header must have finite coordinates of the lower left cell")
    nx, ny = map(int, counts)
    if nx * ny > size:
        raise InputError.at(key, str(path), f"is too short for the {nx} x {ny} values that its header promises")
    return x0 + dx * np.arange(nx), y0 + dy * np.arange(ny)

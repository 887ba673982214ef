"""Files of a campaign's folder, which may come from anybody: checked before anything of them is used.

Each function raises InputError, one line that names the file, for what this program would not have written.
"""

import json
import math
import os
import re
import stat
import zipfile
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, field_validator

from snowmpm.errors import InputError, shown_line
from snowmpm.reading import budget as read_budget

HASH = "^[0-9a-f]{16}$"
"""A run's folder is named so: nothing else may stand in a path."""

MEMORY_PER_BYTE = 40.0
"""Approximate memory of JSON text once it is read."""

CODECS = ("bytes", "zstd", "blosc", "gzip", "zlib", "lz4", "crc32c", "transpose")
"""Codecs of stored arrays that only compress numbers; "pickle" would run code."""

NUMBERS = re.compile(r"[<>|]?[iuf][1248]|u?int(8|16|32|64)|float(16|32|64)")
"""Types of stored arrays."""

METADATA = ("zarr.json", ".zarray", ".zgroup", ".zattrs", ".zmetadata")
MOST_METADATA = 1 << 20
"""Bytes of a file of metadata."""

MOST_FILES = 2_000_000
"""Files of a store."""

OF_THE_TABLE = ("run", "variant", "hash", "status", "reason")
"""Columns of the table that are no numbers of a result."""

TRUTHS = ("final", "saw_runs_to_the_end", "saw_stopped")
"""Numbers of a result that are truth values."""

Number = Annotated[float, Field(strict=False, allow_inf_nan=True)]
Name = Annotated[str, Field(max_length=200, pattern=r"^[^/\\\x00]+$")]


class _Row(BaseModel):
    """A run in plan.json."""

    model_config = ConfigDict(extra="forbid", strict=True)

    variant: Name
    run: Annotated[int, Field(ge=0)]
    values: dict[Name, Any]
    changes: dict[str, Any]
    hash: Annotated[str, Field(pattern=HASH)]


class _Record(BaseModel):
    """record.json of a run."""

    model_config = ConfigDict(extra="forbid", strict=True)

    status: Literal["done", "failed"]
    reason: str
    numbers: dict[Name, bool | Number]
    reasons: dict[Name, str] = {}
    work: dict[str, Any] = {}

    @field_validator("numbers")
    @classmethod
    def _are_results(cls, numbers):
        for name, value in numbers.items():
            if name in OF_THE_TABLE or isinstance(value, bool) != (name in TRUTHS):
                raise ValueError(f"{name} = {value}: not a number of a result")
        return numbers


_ROWS = TypeAdapter(list[_Row])


FOLDERS = ("results", "runs", "pictures", "inputs", "geotiff", "maps.zarr")
"""Folders in that of a campaign."""


def require_no_links(folder):
    """A campaign writes to and deletes from the folders in its own, which may thus not lead elsewhere."""
    of_runs = [path for name in ("results", "runs") for path in Path(folder, name).glob("*")]
    for path in (*(Path(folder, name) for name in FOLDERS), *of_runs):
        if path.is_symlink():
            raise InputError(f"{path}: is a link, and a campaign is written to folders of its own")


def plan_rows(path):
    """Rows of plan.json, a dict each; None where there is no such file."""
    data = _json(path)
    return None if data is None else [row.model_dump() for row in _valid(_ROWS.validate_python, data, path)]


def record(path):
    """What record.json says; None where there is no such file."""
    data = _json(path)
    return None if data is None else _valid(_Record.model_validate, data, path).model_dump()


def _json(path):
    path = Path(path)
    try:
        return json.loads(text_of(path))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, RecursionError) as error:
        raise damaged(path, error) from None


def text_of(path):
    """Text of a file that is one: a pipe or a device may have no end. Raises OSError, ValueError, InputError."""
    path = Path(path)
    if not stat.S_ISREG(path.stat().st_mode):
        raise InputError(f"{path}: is not a file")
    size = path.stat().st_size
    read_budget.allow(path, MEMORY_PER_BYTE * size, "its text")
    with open(path, "rb") as file:
        return file.read(size + 1).decode("utf-8")


def _valid(check, data, path):
    try:
        return check(data)
    except (ValidationError, RecursionError) as error:
        if isinstance(error, ValidationError):
            first = error.errors(include_url=False)[0]
            error = f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
        raise damaged(path, error) from None


def damaged(path, error):
    """InputError of a file that is not as this program writes it. error: the reason, an exception or a text."""
    reason = (str(error).splitlines() or [type(error).__name__])[0]
    return InputError(f"{path}: damaged, or not written by this program ({shown_line(reason, 150)})")


def maps(path, names):
    """{name: array} of maps.npz: rasters (rows, columns) of one shape, corner (2,) [m] and cell [m]."""
    path = Path(path)
    try:
        with zipfile.ZipFile(path) as archive:
            size = float(sum(member.file_size for member in archive.infolist()))
        read_budget.allow(path, 2.0 * size, "its rasters")
        with np.load(path, allow_pickle=False) as file:
            found = {name: file[name] for name in ("corner", "cell", *names) if name in file}
        corner, cell = found["corner"], float(found["cell"])
        shape = found[names[0]].shape
        whole = (corner.shape == (2,) and np.isfinite(corner).all() and math.isfinite(cell) and cell > 0.0
                 and len(shape) == 2 and all(found[name].shape == shape and found[name].dtype.kind == "f"
                                             for name in names))
    except InputError:
        raise
    except Exception as error:  # zipfile and NumPy raise many kinds for what is torn or foreign
        raise damaged(path, str(error) or type(error).__name__) from None
    if not whole:
        raise damaged(path, "corner, cell or the shapes of its rasters are wrong")
    return found


def require_plain_store(folder):
    """Check the metadata of the arrays in a folder of a zarr store: numbers alone, compressed by `CODECS`."""
    files = 0
    for place, folders, names in os.walk(folder):
        files += len(names)
        if files > MOST_FILES:
            raise InputError(f"{folder}: more than {MOST_FILES} files")
        for name in (*folders, *names):
            if os.path.islink(os.path.join(place, name)):
                raise InputError(f"{os.path.join(place, name)}: a link in a store of arrays")
        for name in set(names) & set(METADATA):
            _check_metadata(Path(place, name))


def require_plain_group(folder):
    """Check the metadata of one group of a zarr store."""
    for name in METADATA:
        if (Path(folder) / name).is_file():
            _check_metadata(Path(folder) / name)


def _check_metadata(path):
    try:
        if path.stat().st_size > MOST_METADATA:
            raise ValueError("too large")
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise damaged(path, error) from None
    if not isinstance(data, dict) or path.name == ".zmetadata" or "consolidated_metadata" in data:
        raise damaged(path, "metadata of another kind")
    if path.name == ".zarray" or data.get("node_type") == "array":
        _check_array(path, data)


def _check_array(path, data):
    """An array of numbers that fits the memory, with known codecs."""
    kind = data.get("dtype", data.get("data_type"))
    if not isinstance(kind, str) or not NUMBERS.fullmatch(kind):
        raise damaged(path, f"type of values {kind!r}")
    used = [data.get("compressor"), *(data.get("filters") or ())] if path.name == ".zarray" else data.get("codecs")
    if not isinstance(used, list) or data.get("storage_transformers"):
        raise damaged(path, "no list of codecs")
    for codec in used:
        name = codec.get("id", codec.get("name")) if isinstance(codec, dict) else codec
        if name is not None and name not in CODECS:
            raise InputError(f"{path}: codec {shown_line(repr(name), 60)}: must be one of {', '.join(CODECS)}")
    grid = data.get("chunk_grid")
    grid = grid.get("configuration") if isinstance(grid, dict) else None
    chunks = data.get("chunks", grid.get("chunk_shape") if isinstance(grid, dict) else None)
    for sizes in (data.get("shape"), chunks):
        if not isinstance(sizes, list) or not all(isinstance(n, int) and 0 < n < 2**40 for n in sizes):
            raise damaged(path, "its shape")
    read_budget.allow(path, 8.0 * math.prod(map(float, chunks)), "a block of it")

"""Paths of strain, stress or deformation from a table of text (CSV)."""

import csv
import difflib
import os
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import TypeAlias

import numpy as np

from .arrays import Array
from .loading_stage import LoadingError, LoadingStage
from .symmetric import COMPONENTS

DEFORMATION = tuple(f"F_{i}{j}" for i in "xyz" for j in "xyz")
STRAINS = tuple(f"strain_{component}" for component in COMPONENTS)
STRESSES = tuple(f"stress_{component}" for component in COMPONENTS)
MAX_BYTES, MAX_ROWS = 64 << 20, 200_000
LONGEST_LINE = 10_000
UNITS = {**dict.fromkeys(DEFORMATION + STRAINS, "-"), **dict.fromkeys(STRESSES, "Pa"), "duration": "s"}

Targets: TypeAlias = tuple[dict[str, float], dict[str, float]]
"""Strains and stresses by component."""


@dataclass(frozen=True)
class LoadingFile:
    """A path of n rows, from `read_loading`: either `deformation` (n, 3, 3) or `targets`, n pairs (strain, stress) of
    dictionaries by component; `durations` (n,) [s].
    """

    name: str
    deformation: Array | None
    targets: list[Targets]
    durations: Array

    def stages(self, steps: int) -> list[LoadingStage]:
        """One `LoadingStage` a row."""
        pairs = zip(self.targets, self.durations, strict=True)
        return [LoadingStage(strain, stress, steps, float(duration)) for (strain, stress), duration in pairs]

    def subdivided(self, steps: int) -> tuple[Array, Array]:
        """F (n steps, 3, 3) with `steps` equal parts from I to the first row and from row to row, and the durations."""
        ends = np.concatenate([np.eye(3)[None], self.deformation])
        shares = np.arange(1, steps + 1)[:, None, None] / steps
        F = np.concatenate([(1.0 - shares) * a + shares * b for a, b in pairwise(ends)])
        folded = np.flatnonzero(np.linalg.det(F) <= 0.0)
        if len(folded):
            raise LoadingError(f"{self.name}: det F <= 0 on the way to row {folded[0] // steps + 1}: give rows between")
        return F, np.repeat(self.durations / steps, steps)


def read_loading(file: str | os.PathLike[str]) -> LoadingFile:
    """Read a path -> `LoadingFile`.

    The first line names the columns, each line below is one row: what is reached next. Either
        F_xx F_xy ... F_zz                      total deformation gradient; columns left out: those of the identity
    or any of these, for the components xx yy zz xy yz xz:
        strain_xx [-]                           logarithmic strain or shear from the start (see `loading_stage.py`)
        stress_xx [Pa]                          Cauchy stress, positive in tension
    A component with neither keeps its strain; with both, each row fills in one of the two. In either form
        duration [s]                            time of the row, 1 s without it
    Units in brackets may be left out. Lines that are empty or begin with # are skipped.
    Raises LoadingError, which names the file, the line and the column; OSError for a file that cannot be read.
    """
    file = Path(file)
    if file.exists() and not file.is_file():
        raise LoadingError(f"{file}: not a file")
    if file.stat().st_size > MAX_BYTES:
        raise LoadingError(f"{file}: too large for a path ({file.stat().st_size >> 20} MiB)")
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise LoadingError(f"{file}: not a text file (UTF-8)") from None
    long = next((n for n, line in enumerate(text.splitlines(), 1) if len(line) > LONGEST_LINE), None)
    if long is not None:
        raise LoadingError(f"{file}: line {long}: more than {LONGEST_LINE} characters")
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if len(lines) > MAX_ROWS:
        raise LoadingError(f"{file}: {len(lines) - 1} rows, {MAX_ROWS} at most")
    if len(lines) < 2:
        raise LoadingError(f"{file}: needs a line of column names and at least one row of numbers")
    columns = _columns(file, _cells(file, *lines[0]))
    rows = [_row(file, n, columns, _cells(file, n, line)) for n, line in lines[1:]]
    durations = np.array([row.pop("duration", 1.0) for _, row in rows])
    if columns[0] in DEFORMATION or any(name in DEFORMATION for name in columns):
        return LoadingFile(str(file), np.array([_deformation(file, *row) for row in rows]), [], durations)
    return LoadingFile(str(file), None, [_targets(file, n, columns, row) for n, row in rows], durations)


def _cells(file: Path, n: int, line: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line]))]
    except csv.Error as error:
        raise LoadingError(f"{file}: line {n}: not text ({error})") from None


def _columns(file: Path, cells: list[str]) -> list[str]:
    names: list[str] = []
    for cell in cells:
        name, bracket, rest = cell.partition("[")
        name, unit = name.strip(), rest.removesuffix("]") if bracket else None
        if name not in UNITS:
            near = difflib.get_close_matches(name, UNITS, n=1)
            hint = f"did you mean {near[0]}?" if near else "known are F_xx, strain_xx, stress_xx ... and duration"
            raise LoadingError(f"{file}: column {cell!r} is not known; {hint}")
        if unit is not None and unit != UNITS[name]:
            raise LoadingError(f"{file}: column {name}: the unit must be [{UNITS[name]}], not [{unit}]")
        if name in names:
            raise LoadingError(f"{file}: column {name} comes twice")
        names.append(name)
    if set(names) & set(DEFORMATION) and set(names) & set(STRAINS + STRESSES):
        raise LoadingError(f"{file}: columns F_* describe the whole deformation: no strain_* or stress_* beside them")
    if not set(names) - {"duration"}:
        raise LoadingError(f"{file}: no column says what to do: F_xx, strain_xx or stress_xx ...")
    return names


def _row(file: Path, n: int, columns: list[str], cells: list[str]) -> tuple[int, dict[str, float]]:
    """Line number and the numbers of a row by column; empty cells are left out."""
    if len(cells) != len(columns):
        raise LoadingError(f"{file}: line {n}: {len(cells)} values for {len(columns)} columns")
    values = {}
    for name, cell in zip(columns, cells, strict=True):
        if not cell:
            if name in STRAINS + STRESSES:
                continue
            raise LoadingError(f"{file}: line {n}, column {name}: empty")
        try:
            values[name] = float(cell)
        except ValueError:
            values[name] = float("nan")
        if not isfinite(values[name]) or (name == "duration" and values[name] <= 0.0):
            raise LoadingError(f"{file}: line {n}, column {name} = {cell}: must be a {_wanted(name)}")
    return n, values


def _wanted(name: str) -> str:
    return "number > 0" if name == "duration" else "finite number"


def _deformation(file: Path, n: int, row: dict[str, float]) -> Array:
    F = np.eye(3)
    for name, value in row.items():
        F["xyz".index(name[2]), "xyz".index(name[3])] = value
    if not np.linalg.det(F) > 0.0:
        raise LoadingError(f"{file}: line {n}: det F = {np.linalg.det(F):.4g}: must be > 0")
    return F


def _targets(file: Path, n: int, columns: list[str], row: dict[str, float]) -> Targets:
    for component in COMPONENTS:
        pair = [name for name in (f"strain_{component}", f"stress_{component}") if name in columns]
        if pair and sum(name in row for name in pair) != 1:
            problem = "is empty" if len(pair) == 1 else "and its strain: exactly one of the two must be given"
            raise LoadingError(f"{file}: line {n}, column {pair[-1]} {problem}")
    split: dict[str, dict[str, float]] = {"strain": {}, "stress": {}}
    for name, value in row.items():
        kind, component = name.split("_")
        split[kind][component] = value
    return split["strain"], split["stress"]

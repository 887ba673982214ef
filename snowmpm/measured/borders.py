"""Where an entry of the atlas begins to fail, and the table of all that were measured."""

import functools
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from snowmpm.draft import write_table
from snowmpm.reading.table_file import read_table

SHIPPED = Path(__file__).with_name("stability_borders.csv")
"""The borders that the program goes by: those of `snowmpm study stability`."""


@dataclass(frozen=True)
class Border:
    """Where an entry begins to fail with a setting.

    value: of the entry's parameter, the last that holds, None where nothing fails (held) or everything does; fails:
    "above" or "below" it; lowest, highest: what was tried; title, parameter, unit, cure: the entry's words.
    """

    entry: str
    setting: str
    value: float | None
    fails: str
    lowest: float
    highest: float
    held: bool
    title: str
    parameter: str
    unit: str
    cure: str

    @property
    def in_a_sentence(self):
        """The title, as it goes on a sentence."""
        return self.title if self.title.startswith("SPH") else self.title[0].lower() + self.title[1:]

    def failing(self, value):
        """Whether a scene with this value of the parameter lies on the failing side."""
        if self.value is None:
            return not self.held
        return value > self.value if self.fails == "above" else value < self.value

    def beyond(self, factor):
        """A value of the parameter on the failing side by this factor, on the other by one below 1."""
        return self.value * factor if self.fails == "above" else self.value / factor


def write(borders, path):
    """Write a table of borders."""
    rows = [{**asdict(border), "value": "" if border.value is None else f"{border.value:.4g}"} for border in borders]
    write_table(path, [field.name for field in fields(Border)], [row.values() for row in rows])


def read(path):
    """Borders of a table, by (entry, setting)."""
    return {(row.entry, row.setting): row for row in read_table(Path(path), _border)}


def _border(row):
    return Border(**{
        **{field.name: row[field.name] for field in fields(Border)},
        "value": float(row["value"]) if row["value"] else None, "held": row["held"] == "True",
        "lowest": float(row["lowest"]), "highest": float(row["highest"])})


@functools.cache
def shipped():
    """Borders that the program goes by, by (entry, setting)."""
    return read(SHIPPED)

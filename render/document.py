"""What a report holds, whatever it is written as: blocks in order. `page_of` makes a web page, `write_pdf` a PDF."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from snowmpm.quantities.quantity import Quantity


@dataclass(frozen=True)
class Numbers:
    """A few numbers that matter most: text by what it is."""

    rows: dict[str, str]


@dataclass(frozen=True)
class Note:
    """A marked line: "warning" or "good"."""

    text: str
    kind: str = "warning"


@dataclass(frozen=True)
class Paragraph:
    """A line of text."""

    text: str


@dataclass(frozen=True)
class Picture:
    """A picture or film file, with a line below."""

    path: Path
    words: str = ""


@dataclass(frozen=True)
class Columns:
    """Pictures side by side where there is room."""

    pictures: tuple[Picture, ...]


@dataclass(frozen=True)
class Table:
    """Names and values in two columns; named: `Quantity` by row name, whose definition is one click away."""

    rows: dict[str, str]
    named: dict[str, Quantity] = field(default_factory=dict)


@dataclass(frozen=True)
class Listing:
    """Text as it is, in a fixed pitch; with a summary it is folded in where that can be."""

    text: str
    summary: str | None = None


@dataclass(frozen=True)
class Definitions:
    """What quantities mean."""

    quantities: tuple[Quantity, ...]


@dataclass(frozen=True)
class Live:
    """HTML that moves, for a page only, and the words that stand for it elsewhere."""

    html: str
    words: str = ""


Block: TypeAlias = Numbers | Note | Paragraph | Picture | Columns | Table | Listing | Definitions | Live


@dataclass(frozen=True)
class Section:
    """A headed part; nothing is written of one without blocks."""

    title: str
    blocks: list[Block]


@dataclass(frozen=True)
class Document:
    """title, lead: head of the report; sections: its parts, the first without a title; foot: last line; scripts: names
    of the scripts that its live blocks need."""

    title: str
    lead: str
    sections: list[Section]
    foot: str = ""
    scripts: tuple[str, ...] = ()

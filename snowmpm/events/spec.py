"""What is known of an observed avalanche: the file event.toml, beside the scene that computes it."""

import datetime
import itertools
from pathlib import Path
from typing import Annotated, Any
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field, ValidationError, model_validator

from snowmpm.errors import InputError
from snowmpm.quantities.table import RASTERS
from snowmpm.scenes.messages import describe
from snowmpm.scenes.space import Pair
from snowmpm.scenes.spec import NonNegative, Number, Positive, Spec, one_of, refuse
from snowmpm.scenes.toml import parse

FILE, SCENE = "event.toml", "scene.toml"
MOST_BYTES = 1 << 30
"""Of a file."""
LOOPBACK = ("127.0.0.1", "localhost", "::1")


def is_web(url: str) -> bool:
    """Whether files may come from an address: encrypted, or of this machine."""
    try:
        found = urlsplit(url)
        host = found.hostname or ""
    except ValueError:
        return False
    known = all(0 < len(part) < 64 for part in host.split("."))
    return known and (found.scheme == "https" or (found.scheme == "http" and host in LOOPBACK))


def is_loopback(url: str) -> bool:
    """Whether an address is of this machine."""
    return urlsplit(url).hostname in LOOPBACK


def _checked(url):
    if not is_web(url):
        raise refuse("must be an https address")
    return url


Text = Annotated[str, Field(strict=True, min_length=1, max_length=2000, pattern=r"^[^\x00-\x1f\x7f\x85\u2028\u2029]+$")]
Title = Annotated[str, Field(strict=True, min_length=1, max_length=60, pattern=r"^[^\x00-\x1f\x7f]+$")]
FileName = Annotated[str, Field(strict=True, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.\-]*$", max_length=100)]
"""Of a file in the folder of the event: no path."""
Web = Annotated[str, Field(strict=True, max_length=2000), AfterValidator(_checked)]


class Source(Spec):
    """A file that is fetched."""

    name: FileName
    url: Web
    bytes: Annotated[int, Field(strict=True, gt=0, le=MOST_BYTES)]
    """size of the file"""
    sha256: Annotated[str, Field(strict=True, pattern="^[0-9a-f]{64}$")]
    """checksum of its content"""
    crs: Annotated[str, Field(strict=True, max_length=40)] | None = None
    """coordinate system of a raster that names none, such as EPSG:32632"""


class Brought(Spec):
    """A file that the user brings, since nobody may pass it on, or its address changes."""

    name: FileName
    what: Text
    """what it must be: kind, cell, coordinate system"""
    source: Text
    """where it is had"""
    crs: Annotated[str, Field(strict=True, max_length=40)] | None = None
    """coordinate system of a raster that names none"""
    sha256: Annotated[str, Field(strict=True, pattern="^[0-9a-f]{64}$")] | None = None
    """checksum of its content, where it is known"""


class ObservedArea(Spec):
    """An area that was observed."""

    file: FileName
    """polygons (.shp, .geojson, .gpkg), or a raster (.asc, .tif) whose cells above 0 it is"""
    uncertainty: Positive
    """of the place of its border [m]"""


class Stopped(Spec):
    """Where the avalanche stopped."""

    x: Number
    """easting of the furthest place [m]"""
    y: Number
    """northing of it [m]"""
    uncertainty: Positive
    """of its place along the path [m]"""


class Volume(Spec):
    """The volume of the deposit."""

    value: Positive
    """[m3]"""
    deviation: Positive
    """its standard deviation [m3]"""


class Value(Spec):
    """A value that was measured, at a place or, without one, the largest anywhere."""

    map: one_of(lambda: [one.name for one in RASTERS])
    """what: a map of `snowmpm maps`, such as peak_speed"""
    x: Number | None = None
    """easting [m]"""
    y: Number | None = None
    """northing [m]"""
    within: NonNegative = 0.0
    """how well the place is known [m]: the largest value within that distance is taken"""
    value: NonNegative
    """what was measured, in the unit of the map"""
    deviation: Positive
    """its standard deviation"""
    at_least: bool = False
    """whether the place may have seen more, as of a sensor behind the fastest part: then only too little counts"""
    by: Text
    """how it was measured"""

    @model_validator(mode="after")
    def _has_a_place(self):
        if (self.x is None) != (self.y is None):
            raise refuse("needs both x and y, or none")
        return self


class Observed(Spec):
    """What was observed; at least one."""

    outline: ObservedArea | None = None
    """of all that the flow covered"""
    deposit: ObservedArea | None = None
    """of the deposit"""
    stopped: Stopped | None = None
    """furthest place; that of the outline when missing"""
    deposit_volume: Volume | None = None
    path: Annotated[tuple[Pair, ...], Field(min_length=2)] | None = None
    """line in plan [m], from the release to beyond the deposit, along which run-outs are compared"""
    values: tuple[Value, ...] = ()

    @model_validator(mode="after")
    def _any(self):
        if not (self.outline or self.deposit or self.stopped or self.deposit_volume or self.values):
            raise refuse("must hold at least one of outline, deposit, stopped, deposit_volume, values")
        if self.stopped and not self.path:
            raise refuse("needs path, along which it is compared", "stopped")
        if self.path and any(a == b for a, b in itertools.pairwise(self.path)):
            raise refuse("must have no corner twice in a row", "path")
        return self


class Event(Spec):
    """An observed avalanche."""

    title: Text
    """one line"""
    date: datetime.date
    place: Text
    kind: Text
    """of the avalanche: size, snow, what set it off"""
    credit: Text
    """who made the data"""
    licence: Text
    """of the data"""
    terms: Web
    """text of the licence"""
    accept: Annotated[bool, Field(strict=True)] = False
    """whether the licence must be accepted before files are fetched: any that does more than ask for credit"""
    uses: Text
    """what the licence allows"""
    sources: Annotated[tuple[Text, ...], Field(min_length=1)]
    """publications and repositories"""
    assumed: Annotated[tuple[Text, ...], Field(min_length=1)]
    """what was assumed, since it was not observed"""
    ways: dict[Title, dict[str, Any]] = Field(default_factory=dict)
    """changes of the scene that make another assumption, by its name, as of `--set`"""
    files: tuple[Source, ...] = ()
    brought: tuple[Brought, ...] = ()
    observed: Observed

    @model_validator(mode="after")
    def _names_differ(self):
        parts = (*self.files, *self.brought)
        made = [Path(one.name).with_suffix(".prj").name for one in parts if one.crs]
        names = [*(one.name for one in parts), *made]
        if len({name.lower() for name in (*names, FILE, SCENE)}) < len(names) + 2:
            raise refuse("names a file twice, those that are made for crs included", "files", names)
        return self


def read_event(path: Path) -> Event:
    """`Event` of a file. Raises InputError, which names file, key, value and what is allowed."""
    data = parse(path)
    try:
        return Event.model_validate(data)
    except ValidationError as error:
        raise InputError(describe(error, data, Event, path)) from None

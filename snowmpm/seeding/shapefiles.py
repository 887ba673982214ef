"""Polygons, lines and points of shapefiles, and one of their attributes.

Text that is not needed is not decoded, and an attribute table that cannot be read does not take the polygons with it.
"""

import codecs
from itertools import pairwise

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import companion

LANGUAGES = {
    0x01: "cp437", 0x02: "cp850", 0x03: "cp1252", 0x08: "cp865", 0x09: "cp437", 0x0A: "cp850", 0x0B: "cp437",
    0x0D: "cp437", 0x0E: "cp850", 0x0F: "cp437", 0x10: "cp850", 0x11: "cp437", 0x12: "cp850", 0x13: "cp932",
    0x14: "cp850", 0x15: "cp437", 0x16: "cp850", 0x17: "cp865", 0x18: "cp437", 0x19: "cp437", 0x1A: "cp850",
    0x1B: "cp437", 0x1C: "cp863", 0x1D: "cp850", 0x1F: "cp852", 0x22: "cp852", 0x23: "cp852", 0x24: "cp860",
    0x25: "cp850", 0x26: "cp866", 0x37: "cp850", 0x40: "cp852", 0x4D: "cp936", 0x4E: "cp949", 0x4F: "cp950",
    0x50: "cp874", 0x57: "cp1252", 0x58: "cp1252", 0x59: "cp1252", 0x64: "cp852", 0x65: "cp866", 0x66: "cp865",
    0x67: "cp861", 0x6A: "cp737", 0x6B: "cp857", 0x6C: "cp863", 0x78: "cp950", 0x79: "cp949", 0x7A: "cp936",
    0x7B: "cp932", 0x7C: "cp874", 0x86: "cp737", 0x87: "cp852", 0x88: "cp857", 0xC8: "cp1250", 0xC9: "cp1251",
    0xCA: "cp1254", 0xCB: "cp1253", 0xCC: "cp1257",
}
"""Code page by the language byte of a .dbf file (byte 29 of its head)."""

LONGEST_NAME = 100
"""Bytes of a .cpg file that are read: it holds the name of a code page."""


def read_shapefile(path, key, choose, types=("POLYGON",), plural="polygons"):
    """[(rings, value)] of the polygons of a .shp file, names of its attributes, and warnings.

    types: "POLYLINE" and "POINT" give [(lines, value)], of which a point is one of a single place; plural: how these
    shapes are called; choose: function (names) -> the attribute whose values are
    returned, or None. A shape that is deleted in the table is left out, as other programs do. InputError: no reader,
    unreadable.
    """
    try:
        import shapefile
    except ImportError:
        raise InputError.at(key, str(path), "a shapefile needs the gis extra: pip install 'snowmpm[gis]'") from None
    told, others, found = [], 0, []
    table = companion(path, ".dbf")
    try:
        shapes = _shapes(path, told)
        names, values = _values(table, len(shapes), choose, told)
        for shape, value in zip(shapes, values, strict=True):
            if value is DELETED:
                continue
            if not any(one in shape.shapeTypeName for one in types) or not shape.points:
                others += shape.shapeType != shapefile.NULL
                continue
            points = np.asarray(shape.points, float)[:, :2]
            single = "POINT" in shape.shapeTypeName
            parts = range(len(points) + 1) if single else [*shape.parts, len(points)]
            found.append(([points[a:b] for a, b in pairwise(parts)], value))
    except Exception as error:  # on damaged files pyshp raises struct, OS and its own errors
        raise InputError.at(key, str(path), "is not a readable shapefile") from error
    if others:
        told.append(f"{others} of its geometries are no {plural} and are left out")
    return found, names, told


def _shapes(path, told):
    """Shapes of a file: those that its index .shx names, where there is one. Deleted ones may stay in the .shp."""
    import shapefile

    index = companion(path, ".shx")
    if index is not None:
        try:
            with (open(path, "rb") as stream, open(index, "rb") as places,
                  shapefile.Reader(shp=stream, shx=places) as reader):
                return [reader.shape(i) for i in range(len(reader))]
        except Exception:  # on damaged files pyshp raises struct, OS and its own errors
            told.append(f"its index, {index.name}, cannot be read: all shapes are taken")
    with open(path, "rb") as stream, shapefile.Reader(shp=stream) as reader:
        return reader.shapes()


DELETED = object()
"""In place of the value of a shape that its table says is deleted."""


def _values(table, count, choose, told):
    """Names of the attributes, and the value of the chosen one for each of `count` shapes."""
    import shapefile

    if table is None:
        return (), [None] * count
    try:
        with open(table, "rb") as stream, shapefile.Reader(dbf=stream, encoding=code_page(table),
                                                           encodingErrors="replace") as reader:
            names = tuple(field[0] for field in reader.fields[1:])
            if reader.numRecords != count:
                told.append(f"its table {table.name} has {reader.numRecords} rows for {count} shapes: which belong"
                            " together is unknown, so its attributes are left out")
                return (), [None] * count
            name, values = choose(names), []
            for i in range(count):
                record = reader.record(i, fields=[name] if name else names[:1])
                value = DELETED if record is None else record[0] if name else None
                values.append(_as_written(stream, reader, i, names.index(name)) if name and value is None else value)
            return names, values
    except Exception:  # as above
        told.append(f"its attributes, {table.name}, cannot be read")
        return (), [None] * count


def _as_written(stream, reader, i, number):
    """Text of field `number` of row i, which is no number; None where it is empty."""
    stream.seek(0)
    head = stream.read(12)
    first, length = int.from_bytes(head[8:10], "little"), int.from_bytes(head[10:12], "little")
    sizes = [field[2] for field in reader.fields[1:]]
    stream.seek(first + i * length + 1 + sum(sizes[:number]))
    text = stream.read(sizes[number]).decode("ascii", "replace").strip(" \0")
    return text if text.strip("*") else None


def code_page(table):
    """Code page of the text of a .dbf file: as the .cpg file beside it says, else its language byte, else UTF-8."""
    cpg = companion(table, ".cpg")
    if cpg is not None:
        with open(cpg, "rb") as stream:
            said = stream.read(LONGEST_NAME).decode("ascii", "replace").strip()
        # As programs write it: UTF-8, 1252, CP1252, ANSI 1252, ISO-8859-1, 88591
        last = said.upper().split()[-1] if said else ""
        for name in (last, f"cp{last}", f"iso8859-{last[4:]}" if last.startswith("8859") else last):
            try:
                return codecs.lookup(name).name
            except (LookupError, ValueError):
                continue
    with open(table, "rb") as stream:
        head = stream.read(30)
    return LANGUAGES.get(head[29], "utf-8") if len(head) == 30 else "utf-8"

"""A scene as TOML text, and tables from TOML files."""

import json
from pathlib import Path

from snowmpm import overwriting
from snowmpm.errors import InputError
from snowmpm.reading.toml_text import TOMLDecodeError, tables

MAX_BYTES = 4 << 20  # a scene is written by hand; a larger file is something else

# Tables that read best on one line; every other table gets a header.
INLINE = {"shape", "region", "motion", "boundary", "weak_layer", "base", "within"}


def parse(path):
    """Tables of a TOML file. Raises InputError, which names the file."""
    try:
        overwriting.reads(path)
        if path.stat().st_size > MAX_BYTES:
            raise InputError(f"{path}: too large for a scene file ({path.stat().st_size >> 20} MiB)")
        return tables(path.read_text(encoding="utf-8"), path)
    except TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file (UTF-8)") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def to_toml(scene, leave_out=()):
    """Text of the resolved scene without the tables to leave out. Paths become absolute, so that the text is valid in
    any folder."""
    data = _absolute(scene.model_dump(exclude_none=True, by_alias=True, exclude=set(leave_out)), scene.base_dir)
    return table_text(data)


def table_text(data):
    """Tables by name as TOML text."""
    return "\n".join(_table(data, ())).strip() + "\n"


def value_text(value):
    """A value as TOML text on one line."""
    return _value(value)


def _absolute(value, base_dir):
    if isinstance(value, dict):
        return {
            key: str(Path(base_dir, Path(item).expanduser()))
            if key in ("file", "from") and isinstance(item, str)
            else _absolute(item, base_dir)
            for key, item in value.items()
        }
    if isinstance(value, list | tuple):
        return [_absolute(item, base_dir) for item in value]
    return value


def _table(data, path):
    """Lines of a table: its plain values first, then its tables, as TOML demands."""
    tables = {key: value for key, value in data.items() if _has_header(key, value)}
    for key, value in data.items():
        if key not in tables:
            yield f"{_key(key)} = {_value(value)}"
    for key, value in tables.items():
        inner = (*path, _key(key))
        name = ".".join(inner)
        for item in value if isinstance(value, list) else [value]:
            plain = any(not _has_header(k, v) for k, v in item.items())
            if isinstance(value, list):
                yield from ("", f"[[{name}]]")
            elif plain:
                yield from ("", f"[{name}]")
            yield from _table(item, inner)


def _has_header(key, value):
    if key in INLINE or not value:
        return False
    return isinstance(value, dict) or (isinstance(value, list) and all(isinstance(item, dict) for item in value))


def _key(key):
    return key if key and all(c.isascii() and (c.isalnum() or c in "_-") for c in key) else _value(key)


def _value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str):
        # JSON escapes are TOML escapes; only DEL must be escaped in TOML but not in JSON.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_value(item)}" for key, item in value.items()) + " }"
    return "[" + ", ".join(_value(item) for item in value) + "]"

"""TOML text that anybody may have written, read in bounded time: a scene, a setting, the scene in a run file."""

import re
import sys

from snowmpm.errors import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

TOMLDecodeError = tomllib.TOMLDecodeError

MAX_ENTRIES = 200_000
MAX_DEPTH = 32
DEEP_KEY = re.compile(rf"""(?<![\w"'-])(?:[\w"'-]+[ \t]*\.[ \t]*){{{MAX_DEPTH}}}""")
"""A dotted key of so many parts: reading it takes time that goes with the square of their number."""


def tables(text, where):
    """Tables of a TOML text. Raises TOMLDecodeError; InputError, which begins with `where`, for what is valid but no
    scene: nested deeper than MAX_DEPTH, more than MAX_ENTRIES values, whole numbers beyond 64 bits."""
    if DEEP_KEY.search(text):
        raise InputError(f"{where}: nested too deeply: a key has at most {MAX_DEPTH} parts")
    try:
        data = tomllib.loads(text)
    except TOMLDecodeError:
        raise
    except RecursionError:
        raise InputError(f"{where}: nested too deeply") from None
    except ValueError:  # of Python itself, which reads no number of more than 4300 digits
        raise InputError(f"{where}: a number of too many digits") from None
    _check_extent(data, where)
    return data


def _check_extent(data, where):
    level, entries = [data], 0
    for _ in range(MAX_DEPTH):
        inner = []
        for table in level:
            values = table.values() if isinstance(table, dict) else table
            entries += len(values)
            for value in values:
                if isinstance(value, dict | list):
                    inner.append(value)
                elif isinstance(value, int) and not -(2**63) <= value < 2**63:
                    raise InputError(f"{where}: a whole number beyond 64 bits")
        if not inner:
            break
        if entries > MAX_ENTRIES:
            raise InputError(f"{where}: more than {MAX_ENTRIES} values")
        level = inner
    else:
        raise InputError(f"{where}: nested too deeply")

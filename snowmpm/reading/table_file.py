"""Tables of our own in CSV files, read back: they may have been written over by anybody."""

import csv

from snowmpm.errors import InputError, shown_line

MAX_BYTES = 64 << 20


def read_table(path, convert):
    """`convert(row)` of each row, a dictionary of texts by column, in a CSV file; -> list.

    Raises InputError, which names the file and the line, for a file that is no such table.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(f"{path}: too large for a table ({path.stat().st_size >> 20} MiB)")
        with open(path, newline="", encoding="utf-8") as file:
            return [_converted(path, n, row, convert) for n, row in enumerate(csv.DictReader(file), 2)]
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file (UTF-8)") from None
    except csv.Error as error:
        raise InputError(f"{path}: not a CSV file ({error})") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def _converted(path, n, row, convert):
    try:
        return convert(row)
    except KeyError as error:
        raise InputError(f"{path}: line {n}: has no column {error.args[0]}") from None
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: line {n}: {shown_line(error, 100)}") from None

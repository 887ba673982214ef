"""A profile from a file, by its ending and what it holds."""

from pathlib import Path

from snowmpm.errors import InputError, nearest_file
from snowmpm.pit.caaml import read_caaml
from snowmpm.pit.penetrometer import read_pnt
from snowmpm.pit.profile import SnowProfile
from snowmpm.pit.snowpack import read_pro
from snowmpm.pit.table import read_csv

READERS = {".xml": read_caaml, ".caaml": read_caaml, ".pro": read_pro, ".pnt": read_pnt, ".csv": read_csv}
"""By ending."""


def read_profile(path, time: str | None = None) -> SnowProfile:
    """`SnowProfile` of a CAAML, SNOWPACK (.pro), SnowMicroPen (.pnt) or CSV file; time: of a .pro with several.

    Raises InputError: no such file, no such format, no profile in it, a profile that cannot be.
    """
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{path}: must end in {', '.join(READERS)}: CAAML, SNOWPACK, SnowMicroPen or a table")
    if time is not None and reader is not read_pro:
        raise InputError(f"--time {time}: {path} has one profile; a .pro of SNOWPACK may have many")
    try:
        return read_pro(path, time) if reader is read_pro else reader(path)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file{nearest_file(path)}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None

"""The campaigns that come with the program."""

from pathlib import Path

from snowmpm.errors import InputError, did_you_mean
from snowmpm.scenes.library import FOLDER as SCENES

FOLDER = SCENES / "campaigns"


def campaigns():
    """Name -> what the campaign shows: the first comment line of its file."""
    found = {}
    for path in sorted(FOLDER.glob("*.toml")):
        with path.open(encoding="utf-8") as lines:
            found[path.stem] = next(lines).removeprefix("#").strip()
    return found


def find_campaign(name_or_path):
    """Path of a campaign's file: as given, or of one of the library. Raises InputError if there is none."""
    path = Path(name_or_path)
    if path.suffix == ".toml" or path.is_file():
        return path
    known = campaigns()
    if str(name_or_path) in known:
        return FOLDER / f"{name_or_path}.toml"
    raise InputError(f"no campaign {str(name_or_path)!r} in the library, which has {', '.join(known)}"
                     f"{did_you_mean(str(name_or_path), known)}; a file ends in .toml")

"""The scenes that come with the program."""

from pathlib import Path

FOLDER = Path(__file__).parent / "library"


def library():
    """Name -> what the scene shows: the first comment line of its file."""
    return {path.stem: _first_comment(path) for path in sorted(FOLDER.glob("*.toml"))}


def _first_comment(path):
    with path.open(encoding="utf-8") as lines:
        return next((line.lstrip("# ").strip() for line in lines if line.startswith("#")), "")

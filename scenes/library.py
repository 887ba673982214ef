"""The scenes that come with the program."""

import itertools
from pathlib import Path

FOLDER = Path(__file__).parent / "library"


def library() -> dict[str, str]:
    """Name -> what the scene shows: the first comment line of its file."""
    return {path.stem: _first_comment(path) for path in sorted(FOLDER.glob("*.toml"))}


def comment(name: str) -> list[str]:
    """Description of a library scene: lines of the comment at the head of its file."""
    with (FOLDER / f"{name}.toml").open(encoding="utf-8") as lines:
        head = itertools.takewhile(lambda line: line.startswith("#"), lines)
        return [line.removeprefix("#").removeprefix(" ").rstrip() for line in head]


def _first_comment(path: Path) -> str:
    return next(iter(comment(path.stem)), "")

"""The files that a campaign needs, copied into its folder: it is then all that machines must share.

A file goes to inputs/DIGEST/NAME, with what lies beside it under the same name (.prj, .dbf, .tfw). The digest is that
of its content, so that a changed raster makes other runs.
"""

import hashlib
import shutil
from pathlib import Path

from snowmpm.draft import draft
from snowmpm.errors import InputError

FOLDER = "inputs"
MOST_BESIDE = 20
"""Files of the same name that are copied with one."""


class Inputs:
    """Copies of files in the folder of a campaign."""

    def __init__(self, folder):
        self._folder, self._known = Path(folder), {}

    def of(self, value, *bases):
        """The value with every text under a key `file` replaced by its copy, relative to the folder of the campaign,
        and `from` by an absolute path. bases: folders that relative names are looked for in, in turn."""
        if isinstance(value, dict):
            return {key: self.named(key, item, *bases) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return [self.of(item, *bases) for item in value]
        return value

    def named(self, key, value, *bases):
        """A value under this key, see `of`; key may be dotted."""
        last = key.rpartition(".")[2]
        if not isinstance(value, str) or last not in ("file", "from"):
            return self.of(value, *bases)
        path = _found(value, bases)
        if path is None:
            return value  # the scene refuses it, and says where it looked
        return str(path.resolve()) if last == "from" else self._copied(path)

    def _copied(self, path):
        path = path.resolve()
        if path not in self._known:
            digest = hashlib.sha256(path.read_bytes()).hexdigest()[:12]
            folder = self._folder / FOLDER / digest
            beside = sorted(other for other in path.parent.iterdir()
                            if other.is_file() and other != path and other.name.startswith(path.stem + "."))
            if len(beside) > MOST_BESIDE:
                beside = []
            for one in (*beside, path):
                if not (folder / one.name).exists():
                    with draft(folder / one.name) as part:
                        shutil.copyfile(one, part)
            self._known[path] = f"{FOLDER}/{digest}/{path.name}"
        return self._known[path]


def _found(name, bases):
    if "\0" in name:
        raise InputError(f"{name!r}: not a path")
    for base in bases:
        path = Path(base, Path(name).expanduser())
        if path.is_file() or path.is_dir():
            return path
    return None

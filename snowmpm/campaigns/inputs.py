"""The files that a campaign needs, copied into its folder: it is then all that machines must share.

A file goes to inputs/DIGEST/NAME, with those beside it that belong to it (.prj, .dbf, .tfw). The digest is that of its
content, so that a changed raster makes other runs. Until all is checked, links in a folder of their own stand for the
copies: a campaign that is refused writes nothing, and what could not be read as what it should be is never copied.
"""

import contextlib
import shutil
from pathlib import Path

from snowmpm.draft import draft
from snowmpm.errors import InputError
from snowmpm.reading.named_files import beside, digest_of

FOLDER = "inputs"


class Inputs:
    """Files of a campaign under the names that they will have in its folder; links to them lie in `staging`."""

    def __init__(self, staging):
        self._staging, self._known = Path(staging), {}

    def of(self, value, *bases):
        """The value with every text under a key `file` replaced by its name in the folder of the campaign, and `from`
        by an absolute path. bases: folders that relative names are looked for in, in turn."""
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
        return str(path.resolve()) if last == "from" else self._named(path)

    def _named(self, path):
        path = path.resolve()
        if path not in self._known:
            if path.is_dir():
                raise InputError(f"{path}: a folder, not a file")
            name = f"{FOLDER}/{digest_of(path)[:12]}/{path.name}"
            for one in (path, *beside(path)):
                _link(self._staging / Path(name).with_name(one.name), one)
            self._known[path] = name
        return self._known[path]

    @property
    def known(self):
        """Paths of its files."""
        return set(self._known)

    def told(self, text):
        """A message with the files under their own names."""
        for path, name in self._known.items():
            text = text.replace(str(self._staging / name), str(path))
        return text

    def among(self, value):
        """Names of files of the campaign in a value, or anywhere in its tables and lists."""
        if isinstance(value, dict | list | tuple):
            inner = value.values() if isinstance(value, dict) else value
            return set().union(*map(self.among, inner))
        return {value} if isinstance(value, str) and value in self._known.values() else set()

    def copy(self, folder, read):
        """Copy the files to the folder of the campaign. read: paths of those that were read as what they should be; the
        others raise InputError before anything is written."""
        for path in self._known:
            if path not in read:
                raise InputError(f"{path}: named by the scene, and no run would read it: leave it out")
        for path, name in self._known.items():
            for one in (*beside(path), path):
                there = Path(folder, name).with_name(one.name)
                if not there.exists():
                    with draft(there) as part:
                        shutil.copyfile(one, part)


def _link(link, path):
    link.parent.mkdir(parents=True, exist_ok=True)
    with contextlib.suppress(FileExistsError):
        try:
            link.symlink_to(path)
        except OSError as error:  # Windows makes links for few users only
            if isinstance(error, FileExistsError):
                raise
            shutil.copyfile(path, link)


def _found(name, bases):
    if "\0" in name:
        raise InputError(f"{name!r}: not a path")
    for base in bases:
        path = Path(base, Path(name).expanduser())
        if path.is_file() or path.is_dir():
            return path
    return None

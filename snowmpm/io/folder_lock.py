"""One program at a time in the folder of a run."""

import errno
import os
from pathlib import Path

from snowmpm.errors import InputError

try:
    import fcntl
except ImportError:  # Windows has no advisory locks: a second program is then not refused
    fcntl = None


class FolderLock:
    """Context: locks a folder against other programs; InputError if one has locked it already.

    The folder itself is locked, so no lock file is left behind, and the system releases the lock when a program is
    killed. A folder that does not exist yet is locked by `make`.
    """

    def __init__(self, folder):
        self._folder, self._descriptor = Path(folder), None

    def __enter__(self):
        if self._folder.is_dir():
            self._lock()
        return self

    def make(self):
        """Make the folder if it does not exist, and lock it."""
        self._folder.mkdir(parents=True, exist_ok=True)
        if self._descriptor is None:
            self._lock()

    def _lock(self):
        if fcntl is None:
            return
        self._descriptor = os.open(self._folder, os.O_RDONLY)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            # Some network file systems cannot lock folders; then only the journal of the run file protects it
            if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
                self.__exit__()
                raise InputError(f"{self._folder}: another program is running there; stop it or choose another"
                                 " folder with -o") from None

    def __exit__(self, *error):
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

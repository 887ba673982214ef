"""One program at a time in the folder of a run or a campaign."""

from pathlib import Path

from snowmpm.errors import InputError
from snowmpm.io.locks import Held, Lock


class FolderLock:
    """Context: locks a folder against other programs; InputError if one has locked it already.

    The system releases the lock when a program is killed; where it can lock folders, the folder itself is locked and no
    file is left behind. A folder that does not exist yet is locked by `make`.
    """

    def __init__(self, folder):
        self._folder, self._lock = Path(folder), None

    def __enter__(self):
        if self._folder.is_dir():
            self._take()
        return self

    def make(self):
        """Make the folder if it does not exist, and lock it."""
        self._folder.mkdir(parents=True, exist_ok=True)
        if self._lock is None:
            self._take()

    def _take(self):
        try:
            self._lock = Lock(self._folder)
        except Held:
            raise InputError(f"{self._folder}: another program is running there; stop it or choose another"
                             " folder with -o") from None

    def __exit__(self, *error):
        if self._lock is not None:
            self._lock.release()
            self._lock = None

"""Locks that the system releases when a program is killed, on any system."""

import errno
import os

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

LOCK = ".snowmpm-lock"
"""End of the name of a lock file, where the system cannot lock the thing itself; it stays behind, unlocked."""


class Held(Exception):
    """Another program holds the lock."""


class Lock:
    """A lock on a file or folder that exists, held until `release`. Raises `Held`.

    descriptor: of the open file, where it is open already; the lock then ends with it. Some network file systems cannot
    lock: there, nothing is locked.
    """

    def __init__(self, path, descriptor=None):
        self._own, self._beside = None, None
        if fcntl is None:
            self._lock_beside(path)
        elif descriptor is not None:
            _flock(descriptor)
        else:
            self._own = os.open(path, os.O_RDONLY)
            try:
                _flock(self._own)
            except Held:
                self.release()
                raise

    def _lock_beside(self, path):
        """Lock a file of its own: in a folder, or beside a file."""
        import filelock

        beside = os.path.join(path, LOCK) if os.path.isdir(path) else f"{path}{LOCK}"
        self._beside = filelock.FileLock(beside, timeout=0)
        try:
            self._beside.acquire()
        except filelock.Timeout:
            self._beside = None
            raise Held from None

    def release(self):
        """Give the lock back; twice does no harm."""
        if self._own is not None:
            os.close(self._own)
        if self._beside is not None:
            self._beside.release()
        self._own = self._beside = None


def _flock(descriptor):
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            raise Held from None

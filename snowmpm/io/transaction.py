"""A file that changes atomically from one whole state to the next, even when the program is killed while it writes.

HDF5 rewrites pieces of its metadata in place, so a file that is being written is sometimes unreadable.
`TransactionFile` stands between HDF5 and the disk (h5py's file-object driver):

1. bytes beyond the committed length go straight to the disk, because nothing refers to them yet;
2. changes of committed bytes are held in memory, page by page;
3. `commit` applies those changes atomically through the journal, `abort` discards them.

HDF5 opens and closes the file within each transaction, so what lies on the disk is always a file that was closed
properly: no open-for-write mark, no lock, nothing cached.
"""

import io
import os

import numpy as np

from snowmpm.io.journal import open_own, read_journal, write_all

PAGE = 4096


class TransactionFile(io.RawIOBase):
    """Read-write file object over `path` whose changes reach readers at `commit` only.

    A failed write (disk full) is kept in memory and reported by `commit`: HDF5 then always closes in good order.
    """

    def __init__(self, path, journal):
        super().__init__()
        self._file = open_own(path, os.O_RDWR)
        self._journal = journal
        # The rest of a frame that a kill cut short counts as committed until HDF5 sets the length, in the first
        # transaction: it is then written over like any free space.
        self._committed = self._file.seek(0, io.SEEK_END)
        self._reset()

    def _reset(self):
        self._pages = {}
        self._length = self._committed
        # From the next whole page on: a page is then either held or on the disk, never both.
        self._direct = -(-self._committed // PAGE) * PAGE
        self._error = None
        self._position = 0

    def readable(self):
        return True

    def writable(self):
        return True

    def seekable(self):
        return True

    def seek(self, offset, whence=io.SEEK_SET):
        start = {io.SEEK_SET: 0, io.SEEK_CUR: self._position, io.SEEK_END: self._length}[whence]
        self._position = start + offset
        return self._position

    def tell(self):
        return self._position

    def truncate(self, size=None):
        """Set the length. Bytes that readers may rely on stay on the disk."""
        self._length = self._position if size is None else size
        return self._length

    def readinto(self, buffer):
        """Fill `buffer` from the current position; beyond the end the file reads as zeros."""
        view = memoryview(buffer).cast("B")
        start, stop = self._position, self._position + len(view)
        view[:] = self._on_disk(start, len(view))
        for number in self._pages_between(start, stop):
            page, first = self._pages[number], number * PAGE
            low, high = max(first, start), min(first + PAGE, stop)
            view[low - start : high - start] = page[low - first : high - first]
        self._position = stop
        return len(view)

    def write(self, data):
        """Straight to the disk beyond the committed length, into held pages below it."""
        view = memoryview(data).cast("B")
        start, stop = self._position, self._position + len(view)
        split = min(max(self._direct, start), stop)
        self._hold(start, view[: split - start])
        try:
            if self._error is None and split < stop:
                write_all(self._file, split, view[split - start :])
        except OSError as error:
            self._error = error
        if self._error is not None:
            self._hold(split, view[split - start :])
        self._position = stop
        self._length = max(self._length, stop)
        return len(view)

    def _hold(self, start, view):
        if not len(view):  # otherwise a page beyond the held ones would be held too, and its later bytes lost
            return
        stop = start + len(view)
        for number in range(start // PAGE, -(-stop // PAGE)):
            first = number * PAGE
            if number not in self._pages:
                self._pages[number] = bytearray(self._on_disk(first, PAGE))
            low, high = max(first, start), min(first + PAGE, stop)
            self._pages[number][low - first : high - first] = view[low - start : high - start]

    def _on_disk(self, start, length):
        self._file.seek(start)
        data = b""
        while len(data) < length and (more := self._file.read(length - len(data))):
            data += more
        return data + bytes(length - len(data))

    def _pages_between(self, start, stop):
        first, last = start // PAGE, -(-stop // PAGE)
        if last - first > len(self._pages):
            return [number for number in self._pages if first <= number < last]
        return [number for number in range(first, last) if number in self._pages]

    def begin(self):
        """Start a transaction. Raises OSError when the last commit still cannot be applied."""
        self._journal.finish(self._file)

    def commit(self):
        """Make the new state the one that readers see. Raises OSError (disk full); readers keep the old state."""
        if self._error is not None:
            error = self._error
            self.abort()
            raise error
        try:
            # Readers of the new state need the file at least as long as its superblock says.
            if os.fstat(self._file.fileno()).st_size < self._length:
                self._file.truncate(self._length)
            self._journal.commit(self._file, self._patches())
        except OSError:
            self.abort()
            raise
        self._committed = self._length
        self._reset()

    def _patches(self):
        patches = []
        for number in sorted(self._pages):
            new, old = self._pages[number], self._on_disk(number * PAGE, PAGE)
            changed = np.flatnonzero(np.frombuffer(new, np.uint8) != np.frombuffer(old, np.uint8))
            if len(changed):
                low, high = int(changed[0]), int(changed[-1]) + 1
                patches.append((number * PAGE + low, bytes(new[low:high])))
        return patches

    def abort(self):
        """Discard everything since the last commit, and free its space."""
        self._file.truncate(self._committed)
        self._reset()

    def close(self):
        if not self.closed:
            self._file.close()
        super().close()


class SnapshotFile(io.RawIOBase):
    """Read-only file object: run file `path` with an unfinished commit laid over it, as it was when opened.

    `counter` is the journal's commit counter then; see `snowmpm.io.journal`.
    """

    def __init__(self, path):
        super().__init__()
        self.path = path
        self.counter, self._patches = read_journal(path)
        self._file = open(path, "rb", buffering=0)  # noqa: SIM115 - closed by close()

    def readable(self):
        return True

    def seekable(self):
        return True

    def seek(self, offset, whence=io.SEEK_SET):
        return self._file.seek(offset, whence)

    def tell(self):
        return self._file.tell()

    def readinto(self, buffer):
        view = memoryview(buffer).cast("B")
        start, filled = self._file.tell(), 0
        while filled < len(view) and (more := self._file.readinto(view[filled:])):
            filled += more
        for address, data in self._patches:
            low, high = max(address, start), min(address + len(data), start + filled)
            if low < high:
                view[low - start : high - start] = data[low - address : high - address]
        return filled

    def is_current(self):
        """Whether no commit has begun since this snapshot was opened."""
        return read_journal(self.path)[0] == self.counter

    def close(self):
        if not self.closed:
            self._file.close()
        super().close()

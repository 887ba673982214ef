"""The redo journal beside a run file: the unfinished commit of a killed writer, ready to be completed.

One commit is a list of patches (address, bytes) to bytes that readers already rely on. The journal is

    header   magic, commit counter, payload length, payload checksum, header checksum
    payload  patches, each: address, length, bytes

The payload is written first and the header last, so a torn journal is one whose checksum fails and means "nothing
begun". A payload length of zero means idle. The counter grows by one with each commit: a reader that sees the same
counter before and after has seen one state.

The journal file lives as long as its writer, which holds a lock on it. The run file itself is never locked: any reader
may open it at any time.
"""

import errno
import os
import stat
import struct
import zlib
from contextlib import suppress
from pathlib import Path

from snowmpm.errors import InputError
from snowmpm.io.archive import sync_folder
from snowmpm.io.locks import Held, Lock
from snowmpm.overwriting import NO_LINK, NO_WAIT
from snowmpm.reading import budget as read_budget

MAGIC = b"SNOWJRNL"
HEADER = struct.Struct("<8sQQII")
PATCH = struct.Struct("<QQ")


def journal_path(path):
    """Path of the journal of run file `path`."""
    path = Path(path)
    return path.with_name(path.name + ".journal")


def read_journal(path):
    """(commit counter, patches) of the journal of run file `path`.

    Patches are [(address, bytes)], to be laid over the file; empty unless a commit is, or was, under way. Without a
    journal, or with one that is torn or foreign, the file itself is whole: (None, []).
    """
    try:
        journal = journal_path(path)
        if not journal.is_file():
            return None, []
        read_budget.allow(journal, float(journal.stat().st_size), "what it is to change")
        blob = journal.read_bytes()
    except OSError:
        return None, []
    if len(blob) < HEADER.size:
        return None, []
    magic, counter, length, checksum, header_checksum = HEADER.unpack_from(blob)
    if magic != MAGIC or header_checksum != zlib.crc32(blob[: HEADER.size - 4]):
        return None, []
    payload = blob[HEADER.size : HEADER.size + length]
    if len(payload) < length or zlib.crc32(payload) != checksum:
        return counter, []
    try:
        return counter, _unpack(payload)
    except struct.error:
        return counter, []


def _unpack(payload):
    patches, at = [], 0
    while at < len(payload):
        address, length = PATCH.unpack_from(payload, at)
        at += PATCH.size
        patches.append((address, payload[at : at + length]))
        at += length
    return patches


def open_own(path, flags):
    """An unbuffered file of a run to be changed in place. Raises InputError for a link, which may lead anywhere, and
    for anything that is no file."""
    try:
        descriptor = os.open(path, flags | NO_LINK | NO_WAIT, 0o644)
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise InputError(f"{path}: is a link, and a run is written to files of its own: put the file itself there,"
                             " or link its folder") from None
        raise
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise InputError(f"{path}: is not a file")
    return os.fdopen(descriptor, "r+b", buffering=0)


def write_all(file, address, data):
    """Write all of `data` at `address`: an unbuffered file may silently take less when the disk is nearly full."""
    view = memoryview(data).cast("B")
    file.seek(address)
    while len(view):
        view = view[file.write(view) :]


class Journal:
    """The journal of one writer.

    `durable`: wait for the disk between the steps of a commit, which keeps the file whole through a power cut too;
    without it, only through the death of the program.

    Raises InputError when another process is writing the same run.
    """

    def __init__(self, path, durable=True):
        self.path = journal_path(path)
        self.durable = durable
        self._unapplied = []
        self._file = open_own(self.path, os.O_RDWR | os.O_CREAT)
        try:
            self._lock = Lock(self.path, self._file.fileno())
        except Held:
            self._file.close()
            message = f"{path}: another program is writing this run; stop it or choose another folder"
            raise InputError(message) from None
        if durable:
            sync_folder(self.path.parent)  # or a power cut may lose the journal, but keep its partial changes
        self._counter = 0
        self._finish_for(path)

    def _finish_for(self, path):
        """Complete the commit that a killed writer of `path` left behind, if any."""
        counter, patches = read_journal(path)
        self._counter = counter or 0
        if patches and Path(path).exists():
            with open_own(path, os.O_RDWR) as file:
                self._apply(file, patches)
        self._mark_idle()

    def commit(self, file, patches):
        """Change `file` by all patches or by none.

        Raises OSError when the disk is full, with nothing changed. Once the journal is whole the commit has happened,
        readers see it, and a failure to apply it is left for `finish`.
        """
        self.sync(file)
        payload = b"".join(PATCH.pack(address, len(data)) + data for address, data in patches)
        write_all(self._file, HEADER.size, payload)
        self.sync(self._file)
        self._counter += 1
        self._write_header(len(payload), zlib.crc32(payload))
        self._unapplied = patches
        with suppress(OSError):
            self.sync(self._file)
            self.finish(file)

    def finish(self, file):
        """Apply the patches that the last commit could not apply. Raises OSError if it fails again."""
        if self._unapplied:
            self._apply(file, self._unapplied)
        self._mark_idle()

    def _apply(self, file, patches):
        for address, data in patches:
            write_all(file, address, data)
        self.sync(file)

    def _mark_idle(self):
        self._write_header(0, zlib.crc32(b""))
        self._unapplied = []
        self._file.truncate(HEADER.size)

    def _write_header(self, length, checksum):
        head = HEADER.pack(MAGIC, self._counter, length, checksum, 0)[:-4]
        write_all(self._file, 0, head + struct.pack("<I", zlib.crc32(head)))

    def sync(self, file):
        """Wait until what was written to `file` is on the disk."""
        if self.durable:
            os.fsync(file.fileno())

    def close(self):
        """Remove the journal unless the file still needs it. The lock goes last."""
        if not self._unapplied:
            with suppress(PermissionError):  # Windows removes no file that is open
                self.path.unlink(missing_ok=True)
        self._file.close()
        self._lock.release()

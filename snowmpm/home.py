"""Folders of the user's home, where there may be none: under cron, in containers, in batch jobs.

Nothing heavy is imported here: the package does so first of all.
"""

import os
import stat
from pathlib import Path

HAS_USERS = hasattr(os, "getuid")


def provide() -> None:
    """Name folders in the environment for packages that fail, or complain, without a home that can be written to."""
    if os.name != "posix":
        return
    home = os.path.expanduser("~")
    usable = os.access(home, os.W_OK)
    # Taichi ends the process where it is imported without either
    if not (os.environ.get("HOME") or os.environ.get("XDG_CACHE_HOME")):
        os.environ["XDG_CACHE_HOME"] = os.path.join(home, ".cache") if usable else str(temporary())
    if not usable and "MPLCONFIGDIR" not in os.environ:
        os.environ["MPLCONFIGDIR"] = str(temporary() / "matplotlib")


def temporary() -> Path:
    """A folder of this user alone in the system's temporary folder, the same for each process: programs that are kept
    there are run, so nobody else may have made it."""
    import tempfile  # takes time, and is seldom needed

    user = os.getuid() if HAS_USERS else "user"
    folder = Path(tempfile.gettempdir(), f"snowmpm-{user}")
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        if stat.S_ISDIR(found.st_mode) and _is_mine(found) and os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="snowmpm-"))


def _is_mine(found: os.stat_result) -> bool:
    return not HAS_USERS or (found.st_uid == os.getuid() and not found.st_mode & 0o022)

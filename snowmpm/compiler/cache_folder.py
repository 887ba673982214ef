"""Where compiled kernels are kept: Taichi's folder, or a temporary one where that cannot be written."""

import os
import tempfile
import warnings
from pathlib import Path

from snowmpm import home

VARIABLE = "TI_OFFLINE_CACHE_FILE_PATH"
"""Of the environment: Taichi takes its folder from there."""


def cache_folder(usual):
    """Folder of the kernels: that of the environment or `usual`, else one in the temporary folder.

    Taichi ends the process by SIGSEGV where it cannot write. Warns where the folder is not the usual one: kernels are
    compiled anew once it is emptied.
    """
    wanted = os.environ.get(VARIABLE) or usual
    if _writable(wanted):
        return str(wanted)
    found = str(home.temporary() / "ticache")
    warnings.warn(f"{wanted}: compiled kernels cannot be kept there; they are kept in {found}", stacklevel=5)
    return found


def _writable(folder):
    """Whether files can be made in a folder, which is made if it is missing."""
    try:
        Path(folder).expanduser().mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=Path(folder).expanduser()):
            return True
    except OSError:
        return False

"""Where compiled kernels are kept: a folder beside Taichi's own, or a temporary one where that cannot be written.

Not in Taichi's: other programs keep 100 MB there, and remove what is more when they end. A few of them removed a
quarter of the kernels of the tests (measured), which were compiled anew the next time.
"""

import os
import tempfile
import warnings
from pathlib import Path

from snowmpm import home

VARIABLE = "TI_OFFLINE_CACHE_FILE_PATH"
"""Of the environment: Taichi takes its folder from there."""


def cache_folder(of_taichi):
    """Folder of the kernels: that of the environment or "snowmpm" beside `of_taichi`, else one in the temporary folder.

    Taichi ends the process by SIGSEGV where it cannot write. Warns where the folder is not the usual one: kernels are
    compiled anew once it is emptied.
    """
    wanted = os.environ.get(VARIABLE) or Path(of_taichi).parent / "snowmpm"
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

"""snowmpm as a process: where it is, and how it is run with progress, messages and cancellation."""

import contextlib
import ctypes
import json
import os
import queue
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import time

from processing.core.ProcessingConfig import ProcessingConfig
from qgis.core import QgsApplication, QgsProcessingException

from .words import tr

COMMAND = "SNOWMPM_COMMAND"
"""Setting of Processing: the command of snowmpm, or a folder with it."""
FOREIGN = ("PYTHONHOME", "PYTHONPATH", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "GDAL_DATA", "GDAL_DRIVER_PATH",
           "PROJ_LIB", "PROJ_DATA", "QT_PLUGIN_PATH", "QGIS_PREFIX_PATH")
"""Variables of QGIS's own programs, which would mislead those of another Python."""
WINDOWS = sys.platform == "win32"
NAME = "snowmpm.exe" if WINDOWS else "snowmpm"
PR_SET_PDEATHSIG = 1
PATIENCE = 30.0
"""Seconds for a cancelled program to write its checkpoint, before it is ended."""


def own_folder():
    """The virtual environment that "Set up snowmpm" makes, in the user's profile."""
    return os.path.join(QgsApplication.qgisSettingsDirPath(), "snowmpm")


def scripts(environment):
    """Folder of the commands of a virtual environment."""
    return os.path.join(environment, "Scripts" if WINDOWS else "bin")


def find():
    """Path of the command. Raises QgsProcessingException where there is none."""
    chosen = str(ProcessingConfig.getSetting(COMMAND) or "").strip()
    if chosen:
        places = [chosen, os.path.join(chosen, NAME), os.path.join(scripts(chosen), NAME)]
        for place in places:
            if os.path.isfile(place):
                return place
        raise QgsProcessingException(tr("{} is no command of snowmpm: see Settings > Options > Processing > Providers >"
                                        " snowmpm").format(chosen))
    found = os.path.join(scripts(own_folder()), NAME)
    found = found if os.path.isfile(found) else shutil.which("snowmpm")
    if not found:
        raise QgsProcessingException(tr('snowmpm was not found. Run the algorithm "Set up snowmpm", or name its command'
                                        " in Settings > Options > Processing > Providers > snowmpm."))
    return found


def surroundings():
    """Environment of the program."""
    kept = {name: value for name, value in os.environ.items() if name not in FOREIGN}
    return dict(kept, PYTHONIOENCODING="utf-8", PYTHONUNBUFFERED="1", COLUMNS="100")


class Steps:
    """Parts of the work of an algorithm on one bar of progress."""

    def __init__(self, feedback, shares):
        """shares: of the time that each step takes, about."""
        self._feedback, whole = feedback, sum(shares)
        self._shares, self._done, self._shown = [share / whole for share in shares], 0.0, 0.0

    def next(self):
        """Begin the next step; -> a function of its own share, 0 to 1, that moves the bar."""
        begin, own = self._done, self._shares.pop(0)
        self._done += own

        def show(share):
            self._shown = max(self._shown, begin + own * min(max(share, 0.0), 1.0))
            self._feedback.setProgress(round(100.0 * self._shown, 6))

        show(0.0)
        return show


def run(words, feedback, show=None, folder=None, command=None):
    """Run `snowmpm WORDS --progress json` and wait for it; -> the lines that it printed.

    show: takes the share that is done; folder: to run it in; command: another one, without the option. Its messages go
    to the log as they are. Raises QgsProcessingException with its last words where it fails, or was cancelled.
    """
    line = [*command, *words] if command else [find(), *words, "--progress", "json"]
    feedback.pushCommandInfo(subprocess.list2cmdline(line) if WINDOWS else shlex.join(line))
    options = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW} if WINDOWS else {
        "start_new_session": True, **({"preexec_fn": _end_with_parent} if sys.platform.startswith("linux") else {})}
    try:
        child = subprocess.Popen(line, env=surroundings(), cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                 stderr=subprocess.STDOUT, text=True, encoding="utf-8", errors="replace", **options)
    except OSError as error:
        raise QgsProcessingException(f"{line[0]}: {error.strerror}") from error
    lines = queue.Queue()
    threading.Thread(target=_read, args=(child, lines), daemon=True).start()
    said, cancelled = [], None
    while True:
        if feedback.isCanceled() and cancelled is None:
            cancelled = time.monotonic()
            feedback.pushInfo(tr("Cancelling ..."))
            _interrupt(child)
        if cancelled is not None and time.monotonic() > cancelled + PATIENCE:
            _kill(child)
        try:
            text = lines.get(timeout=0.2)
        except queue.Empty:
            continue
        if text is None:
            break
        if not _progress(text, show):
            said.append(text)
            _tell(text, feedback)
    code = child.wait()
    child.stdout.close()
    if cancelled is not None:
        raise QgsProcessingException(tr("Cancelled. {}").format(" ".join(said[-1:])))
    if code:
        errors = [text for text in said if text.startswith("error:")] or said[-3:]
        raise QgsProcessingException("\n".join(errors) or tr("snowmpm ended with code {}").format(code))
    if show:
        show(1.0)
    return said


def _end_with_parent():
    """In the child: be interrupted when QGIS ends, which may be killed."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGINT)


def _read(child, lines):
    for text in child.stdout:
        lines.put(text.rstrip())
    lines.put(None)


def _progress(text, show):
    """Whether a line is one of progress; it moves the bar."""
    if not text.startswith('{"progress"'):
        return False
    try:
        share = json.loads(text).get("share")
    except ValueError:
        return False
    if show and share is not None:
        show(share)
    return True


def _tell(text, feedback):
    if text.startswith("error:"):
        return  # the exception has it
    if text.startswith("warning:"):
        feedback.pushWarning(text)
    else:
        feedback.pushInfo(text)


def _interrupt(child):
    """Ask the program to end, as Ctrl-C does: it keeps what it has."""
    with contextlib.suppress(OSError):
        child.send_signal(signal.CTRL_BREAK_EVENT if WINDOWS else signal.SIGINT)


def _kill(child):
    with contextlib.suppress(OSError):
        if WINDOWS:
            child.kill()
        else:
            os.killpg(child.pid, signal.SIGKILL)

"""Runs of resumed.toml on disks of several sizes that fill up; to be started in a mount namespace of its own.

    unshare -m python full_disk.py FOLDER PAGES ...

makes in FOLDER/disk a disk of each size (pages of 4 KiB), runs the scene there, then resumes it with room enough, in
FOLDER/PAGES. Prints a line of JSON a size: exit code, message, times of the frames that were readable, exit code and
message of the second start.
"""

import contextlib
import io
import json
import shutil
import subprocess
import sys
from pathlib import Path

from snowmpm import Run
from snowmpm.cli.app import app

SCENE = Path(__file__).with_name("resumed.toml")


def called(*arguments):
    """(exit code, stderr) of a command."""
    message = io.StringIO()
    with contextlib.redirect_stderr(message), contextlib.redirect_stdout(io.StringIO()):
        try:
            app(["run", str(SCENE), "--backend", "cpu", "--threads", "1", "--accept-cost", *arguments])
        except SystemExit as end:
            return end.code or 0, message.getvalue()
    return 0, message.getvalue()


folder = Path(sys.argv[1])
disk = folder / "disk"
disk.mkdir()
for pages in sys.argv[2:]:
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={4 * int(pages)}k", "tmpfs", disk], check=True)
    code, message = called("-o", str(disk / "run"))
    there = (disk / "run" / "run.vtkhdf").exists()
    times = Run(disk / "run").times.tolist() if there else []
    subprocess.run(["mount", "-o", "remount,size=100m", disk], check=True)
    second, again = called("-o", str(disk / "run"), "--resume" if there else "--overwrite")
    shutil.copytree(disk / "run", folder / pages)
    subprocess.run(["umount", disk], check=True)
    print(json.dumps([code, message, times, second, again]), flush=True)

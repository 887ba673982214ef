"""Commands whose results lie on disks of several sizes that fill up; to be started in a mount namespace of its own.

    unshare -m python on_small_disk.py FOLDER RUN2D RUN3D

makes in FOLDER/disk a disk with room enough for each command, then disks with room for shares of what it wrote. Prints
a line of JSON a disk: command, share, exit code, message, {file: size} that it left, and, after space was made, exit
code and files of the same command once more.
"""

import contextlib
import io
import json
import subprocess
import sys
from pathlib import Path

from snowmpm.cli.app import app

PAGE = 4096
SHARES = (0.0, 0.2, 0.4, 0.6, 0.8, 0.95)


def called(arguments):
    """(exit code, stderr) of a command."""
    message = io.StringIO()
    with contextlib.redirect_stderr(message), contextlib.redirect_stdout(io.StringIO()):
        try:
            app(list(map(str, arguments)))
        except SystemExit as end:
            return end.code or 0, message.getvalue()
    return 0, message.getvalue()


def mount(disk, pages, *options):
    subprocess.run(["mount", "-t", "tmpfs", "-o", ",".join([*options, f"size={pages * PAGE}"]), "tmpfs", disk],
                   check=True)


def files(disk):
    return {str(path.relative_to(disk)): path.stat().st_size for path in disk.rglob("*") if path.is_file()}


def main(folder, run, run_3d):
    disk = folder / "disk"
    disk.mkdir()
    out = disk / "out"
    commands = {
        "film": ["render", run, "-o", out / "film.mp4", "--size", "960x600"],
        "gif": ["render", run, "-o", out / "film.gif", "--size", "160x100"],
        "frames": ["render", run, "-o", out, "--size", "160x100"],
        "picture": ["render", run, "-o", out / "picture.png", "--time", "0.1"],
        "interactive page": ["render", run, "-o", out / "page.html"],
        "report": ["report", run, "-o", out / "report.html", "--still"],
        "plot": ["plot", run, "-o", out / "plot.png"],
        "compare": ["compare", run, run, "-o", out / "compare.png"],
        "maps": ["maps", run_3d, "-o", out],
        "new": ["new", "mine", "-o", out, "--like", "avalanche_on_raster"],
        "element": ["element", "oedometer", "-m", "li_cold_dense", "-o", out],
    }
    for name, arguments in commands.items():
        mount(disk, 50_000)
        code, message = called(arguments)
        assert code == 0, message
        whole = files(disk)
        pages = sum(-(-size // PAGE) for size in whole.values())
        subprocess.run(["umount", disk], check=True)
        for share in SHARES:
            mount(disk, 3 + int(share * pages))  # the disk itself and the folder take their own
            code, message = called(arguments)
            left = files(disk)
            mount(disk, 50_000, "remount")
            again = called(arguments)[0]
            print(json.dumps([name, share, code, message, left, again, files(disk), whole]), flush=True)
            subprocess.run(["umount", disk], check=True)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))

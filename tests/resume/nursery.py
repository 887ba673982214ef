"""Runs in processes of their own that start at once: each is a fork of a program that has imported everything.

    python nursery.py SCENE

reads lines `DEATH FOLDER OPTION ...` and answers each with the id of the process that runs `snowmpm run SCENE -o FOLDER
OPTION ...`, then, when that has ended, with its exit code (-9: killed). DEATH is where the process kills itself with
SIGKILL: `frame:N` half-way through its N-th write to the run file or its journal, `checkpoint:N` half-way through its
N-th checkpoint, `before:N` and `after:N` the N-th renaming of a whole file to its name, `resume:1` when a resumed
simulation has its state but not its run file; `none` does not.
"""

import io
import os
import signal
import sys

import numpy as np
import taichi  # noqa: F401

import snowmpm.cli.app
import snowmpm.running.loop
import snowmpm.setup.build
from snowmpm.io import archive, checkpoint, journal, transaction


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def dying(action, number, end):
    """`action`, until it is called for the `number`-th time: then `end` with the same arguments, and death."""
    calls = 0

    def called(*arguments, **named):
        nonlocal calls
        calls += 1
        if calls == number:
            end(*arguments, **named)
            die()
        return action(*arguments, **named)

    return called


def half_written(file, address, data, write=journal.write_all):
    write(file, address, memoryview(data).cast("B")[: len(data) // 2])


def half_saved(file, save=np.savez, **arrays):
    whole = io.BytesIO()
    save(whole, **arrays)
    file.write(whole.getvalue()[: whole.tell() // 2])
    file.flush()


def doom(death):
    """Let this process kill itself there."""
    where, _, number = death.partition(":")
    number = int(number or 0)
    if where == "frame":
        for module in (journal, transaction):
            module.write_all = dying(module.write_all, number, half_written)
    elif where == "checkpoint":
        np.savez = dying(np.savez, number, half_saved)
    elif where in ("before", "after"):
        archive.os.replace = dying(os.replace, number, os.replace if where == "after" else lambda *_: None)
    elif where == "resume":
        checkpoint.take_over = dying(checkpoint.take_over, number, checkpoint.take_over)
    elif where != "none":
        raise ValueError(death)


for line in sys.stdin:
    death, folder, *options = line.split()
    child = os.fork()
    if child == 0:
        with open(f"{folder}.log", "a") as log:
            os.dup2(log.fileno(), 1)
            os.dup2(log.fileno(), 2)
        doom(death)
        snowmpm.cli.app.app(["run", sys.argv[1], "-o", folder, "--backend", "cpu", "--threads", "1", *options])
        os._exit(3)  # the line above ends the process
    print(child, flush=True)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)

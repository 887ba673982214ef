"""Runs in processes of their own that start at once: each is a fork of a program that has imported everything.

    python nursery.py SCENE

reads lines `FOLDER OPTION ...` and answers each with the id of the process that runs `snowmpm run SCENE -o FOLDER
OPTION ...`, then, when that has ended, with its exit code (-9: killed).
"""

import os
import sys

import taichi  # noqa: F401

import snowmpm.build
import snowmpm.cli.app
import snowmpm.loop

for line in sys.stdin:
    folder, *options = line.split()
    child = os.fork()
    if child == 0:
        with open(f"{folder}.log", "a") as log:
            os.dup2(log.fileno(), 1)
            os.dup2(log.fileno(), 2)
        snowmpm.cli.app.app(["run", sys.argv[1], "-o", folder, "--backend", "cpu", "--threads", "1", *options])
        os._exit(3)  # the line above ends the process
    print(child, flush=True)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)

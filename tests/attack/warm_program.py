"""The program, imported once: each line of JSON on stdin becomes a command line in a forked child, under limits.

A request: arguments, folder it runs in, processor time [s], wall time [s], memory [bytes of address space]; the answer:
exit code (below 0: the signal that ended it), out, err, processor time [s], peak of resident memory [bytes].
"""

import contextlib
import json
import os
import resource
import signal
import sys
import time

import h5py  # noqa: F401 - imported here once instead of in every child
import trimesh  # noqa: F401

import snowmpm.advice.report
import snowmpm.cli.app
import snowmpm.render
import snowmpm.running.loop
import snowmpm.scenes  # noqa: F401
from snowmpm.cli import main

for optional in ("rasterio", "shapefile", "shapely", "scipy.spatial"):
    with contextlib.suppress(ImportError):
        __import__(optional)


def in_child(request):
    """Run one command line, its output in the files `out` and `err` of the request's folder for them."""
    os.setpgid(0, 0)
    os.chdir(request["folder"])
    for stream, name in ((sys.stdout, "out"), (sys.stderr, "err")):
        descriptor = os.open(os.path.join(request["output"], name), os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        os.dup2(descriptor, stream.fileno())
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    resource.setrlimit(resource.RLIMIT_AS, (request["memory"],) * 2)
    resource.setrlimit(resource.RLIMIT_CPU, (request["processor"], request["processor"] + 2))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.environ.update(request["environment"])
    sys.argv = ["snowmpm", *request["arguments"]]
    try:
        main()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
    except BaseException:
        import traceback

        traceback.print_exc()
        code = 1
    with contextlib.suppress(OSError):
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(code)


def answered(request):
    pid = os.fork()
    if pid == 0:
        in_child(request)
    with contextlib.suppress(OSError):
        os.setpgid(pid, pid)
    deadline, asked = time.monotonic() + request["wall"], False
    while True:
        ended, status, usage = os.wait4(pid, os.WNOHANG)
        if ended:
            break
        if time.monotonic() > deadline:
            # As a user would, and, if that does not help, as the system would
            with contextlib.suppress(ProcessLookupError):
                os.killpg(pid, signal.SIGKILL if asked else signal.SIGTERM)
            asked, deadline = True, time.monotonic() + 10.0
        time.sleep(0.005)
    return {"code": os.waitstatus_to_exitcode(status), "processor": usage.ru_utime + usage.ru_stime,
            "memory": usage.ru_maxrss * 1024, "in_time": not asked}


def serve():
    requests, answers = os.fdopen(os.dup(0), "r"), os.fdopen(os.dup(1), "w")
    print(json.dumps({"memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024}), file=answers, flush=True)
    for line in requests:
        print(json.dumps(answered(json.loads(line))), file=answers, flush=True)


if __name__ == "__main__":
    serve()

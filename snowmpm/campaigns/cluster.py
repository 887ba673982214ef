"""Where the runs of a campaign go: processes of this machine, a Dask scheduler, or a queue. Needs the extra `cluster`.

Each worker process does one run at a time, with the Taichi threads that the campaign's file says.
"""

import contextlib
import time as clock
from dataclasses import dataclass
from typing import Any

from snowmpm.cores import available_cores
from snowmpm.errors import InputError, SimulationError

SLURM = "slurm"
STARTS = 5
"""Times that the workers of this machine are started, should one die meanwhile."""

DEATHS = 5
"""Times that a worker may die at one run until the run is given up."""

BASE_MEMORY = 1.0 * 2**30
"""Bytes of a worker beside its run: Python, Taichi, compiled kernels."""

SETTINGS = {"distributed.scheduler.allowed-failures": DEATHS,
            "distributed.logging.distributed": "critical",
            "distributed.scheduler.worker-saturation": 1.0,
            "distributed.admin.log-format": "%(message)s",
            "distributed.worker.profile.enabled": False}
"""Of Dask, while a campaign runs: a run that is waiting stays with the scheduler, where any worker can take it; workers
are not sampled, see `work.stop_sampling`."""


def require_cluster():
    """The packages `dask` and `distributed`. Raises InputError, with the command to install them."""
    try:
        import dask
        import distributed
        import pandas  # noqa: F401
        import pyarrow  # noqa: F401
        import xarray  # noqa: F401
        import zarr  # noqa: F401
    except ImportError as error:
        raise InputError(f"campaigns need the cluster extra ({error.name} is missing): pip install"
                         " 'snowmpm[cluster]'") from None
    return dask, distributed


@dataclass
class Site:
    """client: of Dask; address: of a scheduler that is not ours, else None; dashboard: address of its page; cluster:
    that is ours, else None; wanted: number of its workers."""

    client: Any
    address: str | None
    dashboard: str
    cluster: Any = None
    wanted: int = 0

    def workers(self):
        """Addresses of its workers now."""
        return list(self.client.scheduler_info(n_workers=-1)["workers"])

    def replace_lost(self, there):
        """Start workers in place of those that died while they started, of which Dask makes no others. there: number of
        workers now."""
        if self.cluster is not None and there < self.wanted:
            self.cluster.scale(self.wanted)


@contextlib.contextmanager
def site(options, scheduler=None, workers=None, memory=0.0):
    """Context: a `Site`.

    options: table `cluster` of a campaign's file; scheduler: address, "slurm", or None for processes of this machine;
    workers: their number, in place of that of the options; memory: that a run needs [bytes]. Raises InputError for a
    scheduler that does not answer.
    """
    dask, distributed = require_cluster()
    with dask.config.set(SETTINGS), contextlib.ExitStack() as stack:
        if scheduler is None:
            cluster = stack.enter_context(_local(distributed, options, workers, memory))
            client = stack.enter_context(distributed.Client(cluster))
            yield Site(client, None, cluster.dashboard_link, cluster, worker_count(options, workers, memory))
        elif scheduler == SLURM:
            cluster = stack.enter_context(slurm(options, workers))
            client = stack.enter_context(distributed.Client(cluster))
            yield Site(client, None, cluster.dashboard_link)
        else:
            client = connect(distributed, scheduler)
            stack.callback(_close, client)
            yield Site(client, scheduler, client.dashboard_link)


def connect(distributed, address, patience=10.0):
    """Client of the scheduler at an address; waits for it some seconds. Raises InputError when none answers."""
    try:
        return distributed.Client(address, timeout=f"{patience:g}s")
    except (OSError, TimeoutError, ValueError) as error:
        text = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"--scheduler {address}: no Dask scheduler answers there ({text});\nstart one with `dask"
                         " scheduler`, and workers with `dask worker ADDRESS --nthreads 1`") from None


def _close(client):
    with contextlib.suppress(Exception):  # its scheduler may be gone
        client.close(timeout=2)


def worker_count(options, workers=None, memory=0.0):
    """Number of worker processes on this machine: as asked for, else as many as cores and memory allow."""
    if workers or options.workers:
        return workers or options.workers
    from distributed.system import MEMORY_LIMIT

    return max(1, min(available_cores() // options.threads, int(MEMORY_LIMIT // memory_of(memory))))


def memory_of(run):
    """Memory limit [bytes] of a worker whose runs need so much, with a reserve: it is restarted beyond it."""
    return 2.0 * run + BASE_MEMORY


def _local(distributed, options, workers, memory):
    """A cluster of processes of this machine. Raises SimulationError where they cannot be started."""
    resources = {"GPU": 1} if options.backend == "cuda" else None
    reason = ""
    for _ in range(STARTS):
        try:
            return distributed.LocalCluster(
                n_workers=worker_count(options, workers, memory), threads_per_worker=1, processes=True,
                memory_limit=max(int(memory_of(memory)), 2 * 2**30), dashboard_address="127.0.0.1:0", host="127.0.0.1",
                resources=resources, silence_logs=50)
        except (RuntimeError, OSError, TimeoutError) as error:  # a worker died while it started
            reason = (str(error).splitlines() or [type(error).__name__])[0]
            clock.sleep(1.0)
    raise SimulationError(f"no worker can be started here ({STARTS} tries: {reason});\n--resume goes on where it was")


def slurm_options(options):
    """Arguments of `dask_jobqueue.SLURMCluster`: a job is one worker with one run at a time."""
    asked = options.slurm
    given = {name: asked[name] for name in ("queue", "account", "memory", "walltime", "interface")}
    gpu = ["--resources", "GPU=1"] if options.backend == "cuda" else []
    return {**{name: value for name, value in given.items() if value is not None},
            "cores": asked.cores or options.threads, "processes": 1, "job_extra_directives": asked.directives,
            "worker_extra_args": ["--nthreads", "1", *gpu]}


def slurm(options, workers=None):
    """A cluster of SLURM jobs."""
    try:
        from dask_jobqueue import SLURMCluster
    except ImportError:
        raise InputError("--scheduler slurm needs dask-jobqueue: pip install 'snowmpm[cluster]'") from None
    try:
        cluster = SLURMCluster(**slurm_options(options))
    except (TypeError, ValueError) as error:
        raise InputError(f"cluster.slurm: {error}") from None
    cluster.scale(jobs=workers or options.workers or 1)
    return cluster

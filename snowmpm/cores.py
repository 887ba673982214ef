"""How many processor cores there are for this program."""

import math
import os
from pathlib import Path


def available_cores() -> int:
    """Number of processor cores that this process may use: of those it may run on, no more than the share of time that
    its container or batch job has of them (cgroup, version 2 or 1)."""
    own = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, math.ceil(min(own, _quota())))


def _quota() -> float:
    """Cores' worth of time that the groups of this process may take; infinite without a limit."""
    quota = math.inf
    for folder in _groups():
        quota = min(quota, _number(folder / "cpu.max"),
                    _number(folder / "cpu.cfs_quota_us", folder / "cpu.cfs_period_us"))
    return quota


def _groups(root: Path = Path("/sys/fs/cgroup"), own: Path = Path("/proc/self/cgroup")) -> list[Path]:
    """Folders of the groups of this process and of those that hold them: a limit of any of them counts."""
    found = []
    try:
        lines = own.read_text().splitlines()
    except OSError:
        lines = []
    for line in ["0::/", ":cpu:/", ":cpu,cpuacct:/", *lines]:
        _, _, rest = line.partition(":")
        controllers, _, path = rest.partition(":")
        if controllers and "cpu" not in controllers.split(","):
            continue
        base = root / controllers
        inner = Path(path.lstrip("/"))
        found += [base / inner, *(base / parent for parent in inner.parents)]
    return list(dict.fromkeys(found))


def _number(*files: Path) -> float:
    """Quota over period in files of a group; infinite where there is none."""
    try:
        quota, period = (float(word) for word in " ".join(file.read_text() for file in files).split())
    except (OSError, ValueError):  # no such file, or "max"
        return math.inf
    return quota / period if quota > 0 and period > 0 else math.inf

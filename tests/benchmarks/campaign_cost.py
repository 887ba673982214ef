"""What a campaign costs beside its runs: overhead of a run, share of the time that workers are at work, bytes.

    python tests/benchmarks/campaign_cost.py campaigns/valley_friction

reads the folder of a campaign that is done. The overhead of a run is the time of its worker less that of the run
itself: loading the scene, the numbers, the maps, the record. Of a worker's first run it holds imports and kernels. Work
is the time of all runs over that of all workers from the first start to the last end; with an even load it is the
efficiency of the cluster.
"""

import sys
from pathlib import Path

import numpy as np
import pandas


def cost(folder):
    """{what: text} of a campaign's folder."""
    work = pandas.read_csv(folder / "work.csv").sort_values("started")
    end = work.started + work.seconds
    span = end.max() - work.started.min()
    extra = work.seconds - work.wall_time
    first = work.groupby("worker").started.idxmin()
    later = extra.drop(first)
    waits = np.concatenate([one.started.values[1:] - (one.started + one.seconds).values[:-1]
                            for _, one in work.groupby("worker")])
    n, workers = len(work), work.worker.nunique()
    sizes = {name: sum(path.stat().st_size for path in (folder / name).rglob("*") if path.is_file())
             for name in ("runs", "results", "maps.zarr")}
    return {"runs": f"{n} by {workers} workers in {span:.0f} s",
            "run": f"{work.wall_time.mean():.2f} s, {work.processor_time.mean():.2f} s of processor time",
            "overhead of a run": f"{later.mean():.2f} s (median {later.median():.2f} s)",
            "overhead of a worker's first run": f"{extra[first].mean():.2f} s",
            "wait between two runs": f"{1e3 * waits.mean():.0f} ms",
            "workers at work": f"{work.seconds.sum() / (workers * span):.3f} of the time",
            "of which with runs": f"{work.wall_time.sum() / (workers * span):.3f}",
            **{name: f"{size / n / 1e3:.1f} kB a run" for name, size in sizes.items()}}


if __name__ == "__main__":
    for name, text in cost(Path(sys.argv[1])).items():
        print(f"{name:<34} {text}")

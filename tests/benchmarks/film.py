"""Time of a film: processor seconds a picture, and seconds a picture by several threads, of a run that is there.

    python tests/benchmarks/film.py RUN [--pictures 6] [--sizes 1280x720 1920x1080] [--threads 1 2] [--quality preview]

Each size: the median over pictures spread over the run, drawn one by one; then all of them by each number of threads,
in turn, twice. The encoder is left out. The last line names machine, cores and versions.
"""

import argparse
import os
import platform
import time

import numpy as np

from snowmpm.io import Run
from snowmpm.render.run_film import view_of


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("--pictures", type=int, default=6)
    parser.add_argument("--sizes", nargs="+", default=["1280x720", "1920x1080"])
    parser.add_argument("--threads", nargs="*", type=int, default=[1, 2])
    parser.add_argument("--camera", help="Spares the choice of one.")
    parser.add_argument("--quality", default="full", help="Or preview.")
    choice = parser.parse_args()
    run = Run(choice.run)
    frames = [int(i) for i in np.unique(np.linspace(0, len(run) - 1, choice.pictures).round())]
    for size in choice.sizes:
        begun = time.process_time()
        view = view_of(run, tuple(int(side) for side in size.split("x")), camera=choice.camera,
                       quality=choice.quality)
        print(f"{size}, {run.n_points(0):,} particles: view {time.process_time() - begun:.1f} processor s", flush=True)
        view.picture(frames[0])
        each = []
        for i in frames:
            begun = time.process_time()
            view.picture(i)
            each.append(time.process_time() - begun)
        print(f"  a picture {np.median(each):.2f} processor s ({min(each):.2f} to {max(each):.2f})", flush=True)
        for _ in range(2 if choice.threads else 0):
            print("  " + ", ".join(by_threads(view, frames, count) for count in choice.threads), flush=True)
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f},"
          f" Python {platform.python_version()}, NumPy {np.__version__}")


def by_threads(view, frames, count):
    from snowmpm.render.workers import drawn

    begun, used = time.perf_counter(), time.process_time()
    for _ in drawn(view.picture, frames, count):
        pass
    wall, used = time.perf_counter() - begun, time.process_time() - used
    return f"{count} threads {wall / len(frames):.2f} s ({used / len(frames):.2f} processor s) a picture"


if __name__ == "__main__":
    main()

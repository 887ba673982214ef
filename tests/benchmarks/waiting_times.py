"""What a person waits for: whole commands, from the first letter to the last file, in two checkouts in turn.

    python tests/benchmarks/waiting_times.py OLD NEW [--rows list first_step ...] [--turns 5] [-o FILE]
    python tests/benchmarks/waiting_times.py --kernels SCENE [KEY=VALUE ...]

OLD and NEW are folders of the repository (a second one: `git worktree add ../old COMMIT`). Each has a folder of
compiled kernels of its own, empty before the row `cold`, and full before the others. Rows:

    list        snowmpm list
    check       snowmpm check slab_release_2d
    cold        a first step in 2-D from Python, no kernel compiled before
    first_step  the same, kernels compiled before
    run         snowmpm run slab_release_2d on cells of 10 cm, one frame
    job         snowmpm run slab_release --render, the main job of the README of each checkout
    resolved    snowmpm run slab_release_resolved --render, which was slab_release once: the main job of 5f5ffd2d
    film        snowmpm render of that run, 121 frames of 1280 x 720
    report      snowmpm report -o report.pdf of that run

Columns: row; turns; old, new: medians of the processor time with that of all processes started [s]; ratio: median over
the turns of new over old, low, high: its least and its largest; old_wall, new_wall: medians by the clock [s].

--kernels: what a scene compiles until its first step has been made: of each kernel the seconds that Python takes to go
through its source, that the compiler takes, and that loading takes at its first launch, once with nothing on disk and
once with everything.
"""

import argparse
import csv
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

PACKAGES = ("materials", "scenes", "render")
STEP = ("import snowmpm\n"
        "snowmpm.Simulation(snowmpm.load_scene('slab_release_2d', {'solver.dx': 0.1, 'end_time': 2.0})).step()\n")
ROWS = {
    "list": ("-m", "snowmpm", "list"),
    "check": ("-m", "snowmpm", "check", "slab_release_2d"),
    "cold": ("-c", STEP),
    "first_step": ("-c", STEP),
    "run": ("-m", "snowmpm", "run", "slab_release_2d", "--set", "solver.dx=0.1", "--set", "end_time=0.001",
            "-o", "{out}"),
    "job": ("-m", "snowmpm", "run", "slab_release", "--render", "-o", "{job}"),
    "resolved": ("-m", "snowmpm", "run", "{resolved}", "--render", "-o", "{run}"),
    "film": ("-m", "snowmpm", "render", "{run}", "-o", "{out}.mp4"),
    "report": ("-m", "snowmpm", "report", "{run}", "-o", "{out}.pdf"),
}
TWICE = "first_step", "run", "check", "list"
"""Made once before they are timed: kernels, and Python's own compiled modules."""


class Checkout:
    """Commands of one checkout."""

    def __init__(self, folder, scratch):
        self._folder, self._scratch = Path(folder).resolve(), Path(scratch)
        package = self._scratch / "snowmpm"
        package.mkdir(parents=True)
        for part in (*(self._folder / "snowmpm").iterdir(), *(self._folder / name for name in PACKAGES)):
            if not part.is_symlink() and part.name != "__pycache__":
                (package / part.name).symlink_to(part)
        place = str(self._scratch)
        self._env = {**os.environ, "PYTHONPATH": place, "HOME": place, "XDG_CACHE_HOME": f"{place}/cache",
                     "TI_OFFLINE_CACHE_FILE_PATH": str(self._kernels)}
        self._env.pop("PYTHONDONTWRITEBYTECODE", None)
        self._made = 0

    @property
    def _kernels(self):
        return self._scratch / "kernels"

    def timed(self, row):
        """(processor time, time by the clock) [s] of a row."""
        if row == "cold":
            shutil.rmtree(self._kernels, ignore_errors=True)
        self._made += 1
        known = self._folder / "scenes" / "library" / "slab_release_resolved.toml"
        places = {"out": self._scratch / f"out{self._made}", "job": self._scratch / "job", "run": self._scratch / "run",
                  "resolved": known.stem if known.is_file() else "slab_release"}
        if row in ("job", "resolved"):
            shutil.rmtree(places["job" if row == "job" else "run"], ignore_errors=True)
        command = [sys.executable, *(part if "\n" in part else part.format(**places) for part in ROWS[row])]
        before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run(command, check=True, env=self._env, cwd=self._scratch, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
        shutil.rmtree(places["out"], ignore_errors=True)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def compare(row, both, turns):
    """A row of the table."""
    if row in TWICE:
        for checkout in both:
            checkout.timed(row)
    found = [[checkout.timed(row) for checkout in both] for _ in range(turns)]
    ratios = [new[0] / old[0] for old, new in found]
    middle = [[median(turn[k][i] for turn in found) for k in range(2)] for i in range(2)]
    return {"row": row, "turns": turns, "old": f"{middle[0][0]:.2f}", "new": f"{middle[0][1]:.2f}",
            "ratio": f"{median(ratios):.2f}", "low": f"{min(ratios):.2f}", "high": f"{max(ratios):.2f}",
            "old_wall": f"{middle[1][0]:.2f}", "new_wall": f"{middle[1][1]:.2f}"}


def kernels(scene, values):
    """Kernels of a scene up to its first step: (name, source, compiling, loading) [s]."""
    import snowmpm
    from snowmpm.compiler import front_end, launch
    from snowmpm.compiler.backend import impl

    found, kept = {}, (front_end.compiled, front_end._code, launch.Launcher.__call__)

    def compiled(kernel, *args):
        begun, found[kernel.func.__qualname__] = time.perf_counter(), [0.0, 0.0, 0.0]
        inside.append(kernel.func.__qualname__)
        made = kept[0](kernel, *args)
        found[inside.pop()][0] += time.perf_counter() - begun
        return made

    def code(*args):
        begun = time.perf_counter()
        made = kept[1](*args)
        passed = time.perf_counter() - begun
        found[inside[-1]][0] -= passed
        found[inside[-1]][1] += passed
        return made

    def call(self, *args):
        if self._compiled:
            return kept[2](self, *args)
        begun, name = time.perf_counter(), self._kernel.func.__qualname__
        kept[2](self, *args)
        impl.get_runtime().sync()
        if name in found:
            found[name][2] = time.perf_counter() - begun - found[name][0] - found[name][1]
        return None

    inside = []
    front_end.compiled, front_end._code, launch.Launcher.__call__ = compiled, code, call
    snowmpm.Simulation(snowmpm.load_scene(scene, values)).step()
    for name, times in sorted(found.items(), key=lambda item: -sum(item[1])):
        print(f"{name:60s}" + "".join(f"{seconds:8.3f}" for seconds in times))
    print(f"{'all':60s}" + "".join(f"{sum(times[k] for times in found.values()):8.3f}" for k in range(3)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("checkouts", nargs="*", metavar="OLD NEW")
    parser.add_argument("--rows", nargs="+", default=[*ROWS], choices=[*ROWS])
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--kernels", nargs="+", metavar="SCENE")
    parser.add_argument("-o", "--output", type=Path)
    choice = parser.parse_args()
    if choice.kernels:
        values = {key: json.loads(value) for key, value in (part.split("=", 1) for part in choice.kernels[1:])}
        if os.environ.get("SNOWMPM_KERNELS_OF"):
            return kernels(choice.kernels[0], values)
        with tempfile.TemporaryDirectory() as folder:
            env = {**os.environ, "TI_OFFLINE_CACHE_FILE_PATH": folder, "SNOWMPM_KERNELS_OF": "yes"}
            for state in ("nothing on disk", "all on disk"):
                print(f"{state}: seconds of source, of compiling, of the first launch", flush=True)
                subprocess.run([sys.executable, *sys.argv], check=True, env=env)
        return None
    old, new = choice.checkouts
    rows = []
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        both = [Checkout(old, Path(first) / "place"), Checkout(new, Path(second) / "place")]
        for row in choice.rows:
            rows.append(compare(row, both, choice.turns))
            print(rows[-1], flush=True)
    if choice.output:
        with choice.output.open("w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, rows[0], lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
    return None


if __name__ == "__main__":
    main()

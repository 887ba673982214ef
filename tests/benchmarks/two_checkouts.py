"""Time of a step in two checkouts, in turn: ratios that a machine shared with others hardly changes.

    python tests/benchmarks/two_checkouts.py OLD NEW [--case CASE ...] [--threads N] [--turns N] [--seconds S] [-o FILE]
    python tests/benchmarks/two_checkouts.py . . --compilers taichi quadrants

OLD and NEW are folders of the repository (a second one: `git worktree add ../old main`). Each has a process of its own
that makes the same steps of the same case, a few at a time, while the other one waits; they change places from turn to
turn. compilers: of the kernels of each (`docs/taichi_forks.md`). A case is a library scene with values that differ, or
a case of `mpm_step.py`, with options of its solver, its number of particles and its precision:

    --case slab_release_resolved,from=1.0  column_collapse_3d,solver.transfer=aflip \
           layer3,transfer=aflip,particles=250000

from: the time [s] at which the turns begin. Without cases: ten library scenes of all methods.

Columns: compilers; case; threads; particles at the end; steps timed; ns of old and new: processor time a particle and
step, least of the turns; ratio: median over the turns of new over old, low and high: 95 % interval of that median, by
ranks; ratio_wall: by the clock; same: whether both processes ended with the same bits.
"""

import argparse
import csv
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from math import comb
from pathlib import Path
from statistics import median

HERE = Path(__file__).parent
PACKAGES = ("materials", "scenes", "render")
"""Packages that lie beside snowmpm in the repository and are parts of it when installed."""
CASES = ("slab_release_2d", "slab_release", "pst_2d", "column_collapse_3d", "avalanche_on_raster,solver.dx=3",
         "column_collapse_2d,solver.method=sph", "avalanche_depth_averaged", "flexible_wall_2d", "slush_dam_2d",
         "block_wall_2d")
CONFIDENCE = 0.95


def parsed(case):
    """-> name, {option: value}."""
    name, *rest = case.split(",")
    pairs = (part.split("=", 1) for part in rest)
    return name, {key: value if key == "transfer" else _number(value) for key, value in pairs}


def _number(text):
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text


class LibraryScene:
    """Steps of a scene of the library, through all that a run does between frames."""

    def __init__(self, name, options):
        import snowmpm

        begin = options.pop("from", 0.0)
        self.simulation = snowmpm.Simulation(snowmpm.load_scene(name, options))
        while self.simulation.time < begin:
            self.simulation.step()
        self.step = self.simulation.step

    @property
    def solver(self):
        return self.simulation.solver


class LoneSolver:
    """Steps of a case of `mpm_step.py`."""

    def __init__(self, name, options):
        import mpm_step

        options = {"transfer": "apic", "kernel": "quadratic", "gradient": "affine", **options}
        n, precision = options.pop("particles", 250_000), options.pop("precision", "f32")
        self.solver = mpm_step.make_solver(name, n, precision, **options)

    def step(self):
        self.solver.step(self.solver.stable_dt()[0])


def serve(case, threads):
    """Make as many steps as each line of the input says, and answer with what they took."""
    from snowmpm.compiler import runtime

    runtime.start("cpu", threads=threads)
    name, options = parsed(case)
    steps = (LoneSolver if name[:-1] in ("block", "half", "yielding", "layer") else LibraryScene)(name, options)
    for _ in range(5):
        steps.step()
    answer(steps, 0.0, 0.0, 0)
    for line in sys.stdin:
        wall, used, done = time.perf_counter(), time.process_time(), 0
        for _ in range(int(line)):
            steps.step()
            done += steps.solver.particles.count
        answer(steps, time.perf_counter() - wall, time.process_time() - used, done)


def answer(steps, wall, used, done):
    particles = steps.solver.particles
    digest = hashlib.sha256(particles.snapshot().column("velocity").tobytes()).hexdigest()[:16] if done else ""
    print(json.dumps({"wall": wall, "used": used, "particle_steps": done, "particles": particles.count,
                      "digest": digest}), flush=True)


class Checkout:
    """A process that serves a case by the code of a checkout."""

    def __init__(self, folder, case, threads, compiler, stack):
        home = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        package = home / "snowmpm"
        package.mkdir()
        for part in [*(folder / "snowmpm").iterdir(), *(folder / name for name in PACKAGES)]:
            (package / part.name).symlink_to(part)
        environment = {**os.environ, "PYTHONPATH": f"{home}{os.pathsep}{HERE}", "PYTHONDONTWRITEBYTECODE": "1",
                       "SNOWMPM_COMPILER": compiler}
        self._process = stack.enter_context(subprocess.Popen(
            [sys.executable, __file__, "--serve", case, "--threads", str(threads)], env=environment, cwd=home,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True))

    def heard(self):
        while line := self._process.stdout.readline():
            if line.startswith("{"):
                return json.loads(line)
        raise SystemExit("a process ended before its time")

    def take(self, steps):
        self._process.stdin.write(f"{steps}\n")
        self._process.stdin.flush()
        return self.heard()

    def end(self):
        self._process.stdin.close()


def in_turn(both, steps, first):
    """What both took for so many steps, in their usual order; first: who goes first."""
    taken = {k: both[k].take(steps) for k in (first, 1 - first)}
    return [taken[0], taken[1]]


def interval(values):
    """Ranks between which the median lies with CONFIDENCE at least: the k-th least and greatest of n values, where
    2 P(Binomial(n, 1/2) < k) <= 1 - CONFIDENCE; the range of fewer than six."""
    n, k, tail = len(values), 0, 0.5 ** len(values)
    while 2.0 * tail <= 1.0 - CONFIDENCE:
        k += 1
        tail += comb(n, k) * 0.5**n
    values = sorted(values)
    return values[max(0, k - 1)], values[n - max(1, k)]


def compare(folders, case, options):
    """Row of the table."""
    with ExitStack() as stack:
        both = [Checkout(folder, case, options.threads, compiler, stack)
                for folder, compiler in zip(folders, options.compilers, strict=True)]
        for one in both:
            one.heard()
        first = [one.take(5) for one in both]
        steps = max(1, round(5 * options.seconds / max(1e-3, first[0]["wall"])))
        turns = [in_turn(both, steps, first=k % 2) for k in range(options.turns)]
        for one in both:
            one.end()
    ends = turns[-1]
    row = {"compilers": " ".join(dict.fromkeys(options.compilers)), "case": case, "threads": options.threads,
           "particles": ends[0]["particles"], "steps": steps * options.turns}
    for k, name in enumerate(("old", "new")):
        row[name] = min(1e9 * turn[k]["used"] / turn[k]["particle_steps"] for turn in turns)
    ratios = [turn[1]["used"] / turn[0]["used"] for turn in turns]
    row["ratio"] = median(ratios)
    row["low"], row["high"] = interval(ratios)
    row["ratio_wall"] = median(turn[1]["wall"] / turn[0]["wall"] for turn in turns)
    row["same"] = ends[0]["digest"] == ends[1]["digest"]
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("checkouts", nargs="*", type=Path, metavar="OLD NEW")
    parser.add_argument("--case", nargs="+", default=list(CASES))
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--turns", type=int, default=10)
    parser.add_argument("--compilers", nargs=2, default=["taichi", "taichi"], metavar=("OLD", "NEW"))
    parser.add_argument("--seconds", type=float, default=1.0, help="of a turn, about")
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--serve", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve(options.serve, options.threads)
        return
    if len(options.checkouts) != 2:
        parser.error("two checkouts are needed, OLD and NEW")
    for case in options.case:
        row = compare([path.resolve() for path in options.checkouts], case, options)
        shown = {key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()}
        print(shown, flush=True)
        if options.output:
            new = not options.output.exists()
            with open(options.output, "a", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, shown)
                if new:
                    writer.writeheader()
                writer.writerow(shown)


if __name__ == "__main__":
    main()

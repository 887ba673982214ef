"""What steps of each block's own length could save at best: stable steps by block, in runs of library scenes.

    python tests/benchmarks/local_steps.py [NAME ...] [-o FILE]

Every `output.interval` of a run, the longest step of each block is worked out from its own report: waves of its
materials, its fastest particle, its velocity gradient, bonds that break in it. A block that steps 1, 2, 4 or 8 times as
far as the base step takes that share of the work. A block costs its particles and BLOCK more. The base step is, of 25
between half the shortest and the shortest, the one with the least work (to 2 %).

Columns: scene; particles; steps; saved: share of the work of all steps that is saved at best, without transfers between
blocks, without repeated blocks at the borders between levels and with perfectly even work for all threads;
saved_factor_2: with blocks of 1 and 2 alone; graded: with levels of neighbours a factor 2 apart at most; coarse: mean
share of the work in blocks that could step twice as far as all do now, or further; ratio_50, ratio_99: quantiles of a
block's longest step over the shortest, by work; cause_NAME: share of the samples in which that limits the shortest.
"""

import argparse
import csv
from collections import Counter
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from snowmpm.stepping.step_report import BREAKING, GRADIENT2, SPEED2, STRAIN, WAVE2
from snowmpm.stepping.time_step import Extremes, stable_step, strained_cfl

TABLE = Path(__file__).parent / "figures" / "local_steps.csv"
BLOCK = 10.0
"""Time of a block's nodes, in particles."""
LEVELS = 3
CASES = {
    "slab_release_resolved": {"solver.dx": 0.5, "end_time": 8.0, "output.interval": 0.2},
    "avalanche_on_raster": {"solver.dx": 3.0, "end_time": 30.0, "output.interval": 0.5},
    "flow_cold_dense": {"end_time": 2.0, "output.interval": 0.1},
    "column_collapse_2d": {"end_time": 1.0, "output.interval": 0.05},
}


def steps_of_blocks(solver, waves):
    """(longest step [s], cause, work, coordinates) of each block; waves: speed of each material [m/s]."""
    particles = solver.particles
    start = particles.start.to_numpy()[: len(particles.blocks) + 1]
    rows = solver._reports.to_numpy()[: len(particles.blocks)]
    material = particles.material.to_numpy()[: start[-1]]
    many = solver.extremes.breaking > solver._many_break
    found = []
    for b, row in enumerate(rows):
        wave = waves[material[start[b] : start[b + 1]]].max(initial=0.0)
        deviation = row[STRAIN] ** 0.5
        elastic = strained_cfl(solver.cfl, solver.breaking_cfl, deviation, solver.extremes.strained)
        if many and row[BREAKING]:
            elastic = solver.breaking_cfl
        extremes = Extremes(speed=row[SPEED2] ** 0.5, gradient=row[GRADIENT2] ** 0.5, elastic_deviation=deviation,
                            wave_speed=row[WAVE2] ** 0.5)
        found.append(stable_step(solver.dx, elastic, solver.advective_cfl, max(wave, 1e-30), extremes))
    steps, causes = np.array([step for step, _ in found]), [cause for _, cause in found]
    return steps, causes, np.diff(start) + BLOCK, particles.blocks.coordinates


def least_work(steps, work, levels, near=None):
    """Work per time of the base step that needs the least; near: pairs of neighbours, levels apart by 1 at most."""
    shortest, best = steps.min(), np.inf
    for base in shortest * np.linspace(0.5, 1.0, 26)[1:]:
        level = np.floor(np.log2(steps / base * (1.0 + 1e-9))).clip(0, levels).astype(int)
        for _ in range(levels if near is not None else 0):
            np.minimum.at(level, near[:, 0], level[near[:, 1]] + 1)
        best = min(best, float((work / 2.0**level).sum()) / base)
    return best


def neighbours(coordinates):
    """Pairs (n, 2) of blocks that touch, each both ways."""
    at = {tuple(place): b for b, place in enumerate(coordinates.tolist())}
    ways = np.stack(np.meshgrid(*[(-1, 0, 1)] * coordinates.shape[1]), axis=-1).reshape(-1, coordinates.shape[1])
    pairs = [(b, at[other]) for place, b in at.items() for way in ways.tolist() if any(way)
             and (other := tuple(p + w for p, w in zip(place, way, strict=True))) in at]
    return np.array(pairs, int).reshape(-1, 2)


def measured(name, settings):
    """Row of a scene."""
    scene = load_scene(name, settings)
    simulation = Simulation(scene)
    waves = np.array([law.fastest_wave() for law in simulation.model.laws])
    sums, causes, ratios, weights = Counter(), Counter(), [], []
    while simulation.time < scene.end_time * (1.0 - 1e-9):
        simulation.step()
        until = simulation.time + scene.output.interval
        steps, cause, work, coordinates = steps_of_blocks(simulation.solver, waves)
        shortest = steps.min()
        sums["all"] += work.sum() / shortest
        sums["best"] += least_work(steps, work, LEVELS)
        sums["two"] += least_work(steps, work, 1)
        sums["graded"] += least_work(steps, work, LEVELS, neighbours(coordinates))
        sums["coarse"] += work[steps >= 2.0 * shortest].sum() / shortest
        broken = simulation.solver.extremes.breaking > simulation.solver._many_break
        first = cause[int(steps.argmin())]
        causes["breaking" if broken and first == "elastic" else first] += 1
        ratios.append(steps / shortest)
        weights.append(work / shortest)
        while simulation.time < min(until, scene.end_time) * (1.0 - 1e-9):
            simulation.step(until=min(until, scene.end_time))
    ratios, weights = np.concatenate(ratios), np.concatenate(weights)
    order = ratios.argsort()
    share = weights[order].cumsum() / weights.sum()
    quantile = {f"ratio_{q}": ratios[order][np.searchsorted(share, q / 100.0)] for q in (50, 99)}
    saved = {"saved": "best", "saved_factor_2": "two", "graded": "graded"}
    row = {"scene": name, "particles": simulation.n_particles, "steps": simulation.solver.steps,
           **{column: 1.0 - sums[key] / sums["all"] for column, key in saved.items()},
           "coarse": sums["coarse"] / sums["all"], **quantile}
    return row | {f"cause_{cause}": causes[cause] / causes.total()
                  for cause in ("elastic", "breaking", "advective", "deformation")}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", default=list(CASES))
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    choice = parser.parse_args()
    runtime.start("cpu", 1)
    rows = []
    for name in choice.names:
        rows.append(measured(name, CASES[name]))
        print(", ".join(f"{key} {value:.3g}" if isinstance(value, float) else f"{key} {value}"
                        for key, value in rows[-1].items()), flush=True)
        with choice.output.open("w", newline="") as file:
            table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            table.writeheader()
            table.writerows({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()}
                            for row in rows)


if __name__ == "__main__":
    main()

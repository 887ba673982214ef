"""BM-1: a column of grains against a flexible wall, by two couplings on three grids; a table, and a chart of the tip.

    python tests/benchmarks/column_against_wall.py [--grids 5 2.5 2] [--couplings one_body parts] [-o FOLDER]

One body: soil and wall share the velocities of the grid, and stick to each other. Parts: the wall is a chain of
segments with strong coupling, which the soil may leave. Of each run: the first peak of the tip's displacement, its mean
after 0.8 s, half of its range and its period after the first peak, the gap between soil and wall and the mass of soil
in the upper left that has moved by more than 5 mm, both at 0.5 s.
"""

import argparse
import csv
import sys
import time
from pathlib import Path

import numpy as np

from snowmpm import Simulation

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.support.column_against_wall import HIGH, scene

EVERY, AT, LATE = 2e-3, 0.5, 0.8
COLUMNS = ("coupling", "dx", "particles", "steps", "first_peak", "late", "half_range", "period", "gap", "upper_left",
           "unsettled", "seconds")


def measure(dx, one_body, until=1.0, **more):
    """Times [s] and displacements of the tip [m], and the numbers of the table, in m, s and kg/m."""
    began = time.process_time()
    simulation = Simulation(scene(dx, one_body, until, **more))
    soil = simulation.numbers_of_body(0)
    start = _places(simulation)
    tip = _top_row(simulation, start, dx) if one_body else None
    times, found, row = [0.0], [0.0], {}
    while simulation.time < until - 1e-9:
        wanted = times[-1] + EVERY
        while simulation.time < wanted - 1e-9:
            simulation.step(until=wanted)
        times.append(simulation.time)
        if one_body:
            found.append(float((_places(simulation)[tip] - start[tip])[:, 0].mean()))
        else:
            found.append(simulation.solver.movers["structures"].row(simulation.solver.gravity)["wall_top_x"])
        if abs(simulation.time - AT) < 0.5 * EVERY:
            row = at_half(simulation, start, soil, one_body)
    rods = simulation.solver.movers.get("structures")
    row.update(coupling="one body" if one_body else "parts", dx=dx, particles=simulation.n_particles,
               steps=simulation.solver.steps, unsettled=rods.unsettled if rods else 0, **of_tip(times, found),
               seconds=time.process_time() - began)
    return np.array(times), np.array(found), row


def of_tip(times, found):
    """First peak, late mean, half range and period of the tip's displacement."""
    times, found = np.array(times), np.array(found)
    smooth = np.convolve(found, np.ones(5) / 5.0, "same")
    tops = np.flatnonzero((smooth[1:-1] > smooth[:-2]) & (smooth[1:-1] >= smooth[2:])) + 1
    tops = tops[smooth[tops] > 0.3 * smooth.max()]
    first = tops[0] if len(tops) else int(smooth.argmax())
    after = times > times[first]
    swing = found[after] - np.convolve(found, np.ones(101) / 101.0, "same")[after]
    down = np.flatnonzero((swing[1:] < 0.0) & (swing[:-1] >= 0.0))
    return {"first_peak": float(found[max(0, first - 3) : first + 4].max()),
            "late": float(found[times > LATE].mean()) if times[-1] > LATE else np.nan,
            "half_range": float(np.ptp(found[after]) / 2.0),
            "period": float(np.diff(times[after][down]).mean()) if len(down) > 1 else np.nan}


def at_half(simulation, start, soil, one_body):
    """Gap between soil and wall, in the lower 20 mm, and the mass in the upper left that moved."""
    now, mass = _places(simulation), simulation.particles["mass"][np.argsort(simulation.particles["id"])]
    own = slice(*soil)
    spacing = float(np.sqrt(simulation.model.population.volumes[0]))
    low = (now[own, 1] < 0.02)
    front = now[own][low, 0].max() + 0.5 * spacing
    if one_body:
        wall = now[soil[1]:]
        face = wall[wall[:, 1] < 0.02, 0].min() - 0.5 * spacing
    else:
        rod = simulation.solver.movers["structures"].rods[0].rod
        face = float(np.interp(0.01, rod.x[:, 2], rod.x[:, 0])) - 0.005
    moved = np.linalg.norm(now[own] - start[own], axis=1) > 0.005
    left = (start[own, 0] < 0.1) & (start[own, 1] > 0.5 * HIGH)
    return {"gap": float(face - front), "upper_left": float(mass[own][moved & left].sum())}


def _places(simulation):
    particles = simulation.particles
    return particles["position"][np.argsort(particles["id"])][:, [0, -1]]


def _top_row(simulation, start, dx):
    wall = np.arange(len(start)) >= simulation.numbers_of_body(1)[0]
    return np.flatnonzero(wall & (start[:, 1] > HIGH - 0.6 * dx))


def chart(curves, path):
    """Displacement of the tip over time, by coupling and grid."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for (times, found, row) in curves:
        panel = panels[0 if row["coupling"] == "one body" else 1]
        panel.plot(times, 1e3 * found, label=f"{1e3 * row['dx']:g} mm")
        panel.set_title("one body: soil and wall stick" if row["coupling"] == "one body" else "parts: soil may leave")
    for panel in panels:
        panel.set_xlabel("time [s]")
        panel.legend(title="grid")
    panels[0].set_ylabel("displacement of the tip [mm]")
    figure.savefig(path, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--grids", type=float, nargs="+", default=[5.0, 2.5, 2.0], help="[mm]")
    parser.add_argument("--couplings", nargs="+", choices=["one_body", "parts"], default=["one_body", "parts"])
    parser.add_argument("--until", type=float, default=1.0)
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "figures")
    options = parser.parse_args()
    curves = []
    for coupling in options.couplings:
        for grid in options.grids:
            curves.append(measure(1e-3 * grid, coupling == "one_body", options.until))
            print({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in curves[-1][2].items()},
                  flush=True)
            write([row for _, _, row in curves], options.output / "column_against_wall.csv")
    np.savez_compressed(options.output / "column_against_wall.npz", **{
        f"{row['coupling']} {1e3 * row['dx']:g}": np.stack([times, found]) for times, found, row in curves})
    chart(curves, options.output / "column_against_wall.png")


def write(rows, path):
    """The table."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()}
                         for row in rows)


if __name__ == "__main__":
    main()

"""A surrogate of a layer of grains on paths that it has not seen, beside the law fitted to the same sample.

    python tests/benchmarks/grains_surrogate.py [--grains N] [--learnt N] [--unseen N] [--voxels N]

The sample of `snowmpm grains`. Paths are random (`random_jumps`), the unseen ones drawn after the others. The law comes
from the six tests of `driven_tests`, not from the paths. Writes figures/grains_surrogate.csv and
.png. Columns: path; traction, law: root mean square differences over the largest traction
of the path; covered: share of tractions within the 95 % intervals; permeability: root mean square of log(ratio).
"""

import argparse
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.compiler import runtime
from snowmpm.draft import write_table
from snowmpm.micro.grains.bonded import bonded_cell
from snowmpm.micro.grains.contact import ContactLaw
from snowmpm.micro.grains.curves import DrivenCurve, driven_tests
from snowmpm.micro.grains.fitting import fitted_law, predictions
from snowmpm.micro.grains.surrogate import Surrogate, learnt_path, random_jumps, unseen_errors

HERE = Path(__file__).parent
CLOSING, SEED = 0.1, 7
RADIUS, SOLID, DENSITY = 5e-4, 0.38, 110.0
BONDS = ContactLaw(8e3, 4e3, friction=0.2, strength=2.72e4, shear_strength=2.72e4)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, value in (("grains", 200), ("learnt", 12), ("unseen", 4), ("voxels", 32)):
        parser.add_argument(f"--{name}", type=int, default=value)
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    sample = bonded_cell(options.grains, RADIUS, BONDS, SOLID, 2, density=DENSITY / SOLID)
    start = time.process_time()
    turns = random_jumps(options.learnt + options.unseen - 1, CLOSING, np.random.default_rng(SEED))
    paths = [learnt_path(sample, jumps, options.voxels) for jumps in ([(-CLOSING, 0.0)], *turns)]
    driven = time.process_time() - start
    learnt, unseen = paths[: options.learnt], paths[options.learnt :]
    surrogate = Surrogate(learnt)
    trained = time.process_time() - start - driven
    start = time.process_time()
    surrogate.traction(unseen[0].jump)
    asked = (time.process_time() - start) / len(unseen[0].jump)
    print(f"paths {driven:.0f} s, learning {trained:.0f} s, {1e6 * asked:.0f} us a row")
    law = fitted_law(driven_tests(sample), density=DENSITY).law
    rows, shown = [], []
    for k, path in enumerate(unseen, 1):
        errors, by_law = unseen_errors(surrogate, path), law_traction(law, path)
        steps = np.linalg.norm(np.diff(path.jump, axis=0), axis=1)
        way = np.gradient(np.concatenate([[0.0], np.cumsum(steps)]))
        largest = np.linalg.norm(path.traction, axis=1).max()
        of_law = np.sqrt((((by_law - path.traction) ** 2).sum(axis=1) * way).sum() / way.sum()) / largest
        rows.append([k, *(f"{value:.3g}" for value in (errors["traction"], of_law, errors["covered"],
                                                       errors["permeability"])),
                     f"{surrogate.knows(path.jump).mean():.2f}"])
        shown.append((path, *surrogate.traction(path.jump), by_law))
        print(rows[-1], flush=True)
    write_table(HERE / "figures" / "grains_surrogate.csv",
                ["path", "traction", "law", "covered", "permeability", "within_range"], rows)
    draw(shown, rows)


def law_traction(law, path):
    """T (n, 2) of a law along the jumps of a path."""
    F = np.tile(np.eye(3), (len(path.jump), 1, 1))
    F[:, 2, 2] += path.jump[:, 0]
    F[:, 0, 2] = path.jump[:, 1]
    curve = DrivenCurve("path", F, np.zeros_like(F), np.ones(len(F)))
    stress = predictions(law, [curve])[0]
    return DrivenCurve("path", F, stress, curve.bonds).traction[:, [2, 0]]


def draw(shown, rows):
    figure = Figure(figsize=(10.0, 5.2), layout="constrained")
    panels = figure.subplots(2, len(shown), sharey="row", squeeze=False)
    for column, ((path, found, spread, by_law), row) in enumerate(zip(shown, rows, strict=True)):
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path.jump, axis=0), axis=1))])
        for k, name in enumerate(("normal", "tangential")):
            panel = panels[k, column]
            panel.plot(way, 1e-3 * path.traction[:, k], "0.4", lw=0.7, label="grains")
            panel.plot(way, 1e-3 * found[:, k], "C0", lw=1.4, label="surrogate, 95 %")
            panel.fill_between(way, *(1e-3 * (found[:, k] + sign * 1.96 * spread[:, k]) for sign in (-1, 1)),
                               color="C0", alpha=0.2, lw=0)
            panel.plot(way, 1e-3 * by_law[:, k], "C3--", lw=1.0, label="fitted law")
            panel.set(xlabel="way over height" if k else "",
                      ylabel="" if column else f"{name} traction [kPa]")
        title = f"surrogate {100 * float(row[1]):.0f} %, law {100 * float(row[2]):.0f} %"
        panels[0, column].set_title(title, fontsize=9)
    panels[0, 0].legend(fontsize=7)
    figure.savefig(HERE / "figures" / "grains_surrogate.png", dpi=90)


if __name__ == "__main__":
    main()

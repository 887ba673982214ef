"""Tests of a cell of grains beside the law that was made from them."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from snowmpm.annotations import Numbers, PathLike
from snowmpm.render.figure import check_ending, save, titled


class GrainsCurve(NamedTuple):
    """A test: name; amount of the strain (n,); stresses of grains and law (n,) [Pa] by name."""

    name: str
    strain: Numbers
    grains: dict[str, Numbers]
    law: dict[str, Numbers]


def render_grains(curves: Sequence[GrainsCurve], output: PathLike, title: str = "") -> Path:
    """Draw tests of grains beside a law, a panel each. Returns the path."""
    check_ending(output)
    columns = min(3, max(1, len(curves)))
    rows = -(-len(curves) // columns)
    figure = Figure(figsize=(4.2 * columns, 3.1 * rows), layout="constrained")
    if title:
        figure.suptitle(title, fontsize=10)
    for place, curve in enumerate(curves, 1):
        panel = figure.add_subplot(rows, columns, place)
        for number, (name, values) in enumerate(curve.grains.items()):
            panel.plot(curve.strain, 1e-3 * values, color=f"C{number}", lw=0.8, alpha=0.7, label=f"{name}, grains")
            panel.plot(curve.strain, 1e-3 * curve.law[name], color=f"C{number}", lw=1.6, ls="--", label=f"{name}, law")
        titled(panel, curve.name, "strain", "stress [kPa]")
        panel.legend(fontsize=7)
    return save(figure, output, 110)

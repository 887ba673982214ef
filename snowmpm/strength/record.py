"""What a strength reduction leaves in its folder: the search as a table, the answer, the slip surface."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm.comparison.answers.slope_stability import Slope, plane_strain_strength, upper_surface
from snowmpm.draft import write_table, write_text
from snowmpm.scenes.schema import Scene
from snowmpm.strength.displacement import Ways, slip_surface
from snowmpm.strength.reduction import Reduction

CELLS = 2.0
"""Width of a column of the slip surface over dx."""


def answer(reduction: Reduction, ways: Ways) -> dict[str, Any]:
    """The numbers of a reduction by name. ways: of the first trial that slides."""
    found, share = reduction.found, float(ways.slid.mean())
    known = slices(reduction)
    return {
        "factor_of_safety": found.slides, "stands_at": found.stands, "step": reduction.step,
        "divided": reduction.way, "materials": list(reduction.materials),
        "method": reduction.scene.solver.method, "dx": reduction.scene.solver.dx,
        "height": reduction.height, "duration": reduction.duration, "speed_limit": reduction.limit,
        "rest_factor": reduction.rest_factor, "share_that_slides": share,
        **({} if known is None else {"bishop": known[0].factor}),
    }  # fmt: skip


def slices(reduction: Reduction):
    """`slices_of` its scene."""
    return slices_of(reduction.scene, reduction.gravity)


def slices_of(scene: Scene, gravity: float):
    """The critical circle of Bishop's slices and the `Slope`, of a slope of one polygon of soil in 2-D; or None.
    gravity [m/s2]."""
    if scene.dimension != 2 or len(scene.bodies) != 1 or scene.bodies[0].shape.kind != "polygon" or scene.terrain:
        return None
    law = scene.materials[scene.bodies[0].material]
    try:
        cohesion, angle, _ = plane_strain_strength(law.model_dump())
    except (ValueError, KeyError):
        return None
    points = np.array(scene.bodies[0].shape.points, float)
    x, z = upper_surface(points)
    slope = Slope(x, z, float(points[:, 1].min()), law.density * gravity, cohesion, float(np.tan(angle)))
    circle = slope.critical()
    return (circle, slope) if np.isfinite(circle.factor) else None


def write(reduction: Reduction, ways: Ways) -> dict[str, Path]:
    """search.csv, strength.json and slip_surface.csv; their paths by name."""
    folder, dim = reduction.folder, reduction.scene.dimension
    paths = {"search": folder / "search.csv", "answer": folder / "strength.json", "slip": folder / "slip_surface.csv"}
    trials = reduction.found.trials
    write_table(paths["search"], ["factor", "verdict", "speed [m/s]", "way [m]", *trials[0].strengths, "run"],
                [[f"{t.factor:g}", "slides" if t.slides else "stands", f"{t.speed:.6g}", f"{t.way:.6g}",
                  *(f"{value:.8g}" for value in t.strengths.values()), t.folder] for t in trials])
    write_text(paths["answer"], json.dumps(answer(reduction, ways), indent=1))
    surface = slip_surface(ways, CELLS * reduction.scene.solver.dx)
    write_table(paths["slip"], [f"{axis} [m]" for axis in ("xz" if dim == 2 else "xyz")],
                [[f"{value:.6g}" for value in row] for row in surface])
    return paths

"""Dams that break, as scenes that a user can write: a layer that ends at x = 0 in a channel three cells wide."""

import numpy as np

from snowmpm.scenes import Scene
from tests.support.dam_breaks import DryDam

LINES = 3


def dry_scene(dam: DryDam, dx, time, rear, **depth):
    """`Scene` of `DryDam`, 1 m of snow `rear` [m] long; depth: keys of [solver.depth], columns when it names none."""
    cosine = np.cos(np.radians(dam.slope))
    ends = [-rear * cosine, 1.05 * dam.place(0.0, time) * cosine + 10.0 * dx]
    return _scene(dx, time, ends, dam.slope, float(np.tan(np.radians(dam.friction))), [("snow", 1.0, [ends[0], 0.0])],
                  {"depth": {"scheme": "columns", **depth}}, "slip" if dam.slope == 0.0 else "open")


def wet_scene(dx, time, ahead, **solver):
    """`Scene` of 1 m of snow beside `ahead` [m], on the flat; columns, where `solver` names no other scheme."""
    solver = {"depth": {"scheme": "columns"}, **solver}
    bodies = [("dam", 1.0, [-6.0, 0.0]), ("bed", ahead, [0.0, 8.0])]
    return _scene(dx, time, [-6.0, 8.0], 0.0, 0.0, bodies, solver, "slip", "slip")


def _scene(dx, time, ends, angle, friction, bodies, solver, rear="slip", end="open"):
    return Scene.model_validate({
        "name": "dam", "dimension": 3, "end_time": time, "output": {"interval": time},
        "solver": {"method": "depth", "dx": dx, **solver},
        "domain": {"min": [ends[0], 0.0, -100.0], "max": [ends[1], LINES * dx, 100.0],
                   "boundary": {"x_min": rear, "x_max": end, "y_min": "slip", "y_max": "slip"}},
        "terrain": {"kind": "plane", "angle": angle, "friction": friction},
        "materials": {"snow": {"kind": "elastic", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": name, "material": "snow", "shape": {
            "kind": "layer", "top": top, "region": {"x": region, "y": [0.0, LINES * dx]}}}
            for name, top, region in bodies]})


def profile_of(run, dx, angle=0.0):
    """x in steps of dx and depth h at the end of a run, along and normal to the plane [m], from the `depth` that frames
    hold of each column."""
    frame, cosine = run.frame(-1), np.cos(np.radians(angle))
    x = (frame.points[:, 0] + run.origin[0]) / cosine
    order = np.argsort(x)
    at = dx * np.arange(np.ceil(x.min() / dx), x.max() / dx + 3.0)
    return at, np.interp(at, x[order], frame.fields["depth"][order], right=0.0)

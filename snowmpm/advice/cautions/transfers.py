"""Rules: spurious effects of transfers and splines on the motion."""

from snowmpm.advice.cautions.caution import Caution, beyond, rule, worded
from snowmpm.measured.borders import shipped
from snowmpm.schemes import BASES, TRANSFERS


@rule("mpm")
def null_space_noise(facts):
    """Motion that the grid cannot see, which a large share of FLIP lets grow."""
    solver = facts.scene.solver
    if TRANSFERS[solver.transfer].flip:
        setting = "flip cubic" if solver.transfer == "flip" and solver.kernel == "cubic" else solver.transfer
        if border := beyond("null_space_noise", setting, solver.flip_ratio):
            yield worded(border, "solver.flip_ratio", solver.flip_ratio)


@rule("mpm")
def damped_waves(facts):
    """Damping by PIC or a small share of FLIP, for the longest wave of a body, of twice its length."""
    solver = facts.scene.solver
    settings = {"pic": [("pic", 0.0)], "flip": [("flip 0.95", 0.95), ("flip 0.99", 0.99)]}.get(solver.transfer, [])
    known = [name for name, ratio in settings if solver.transfer == "pic" or solver.flip_ratio <= ratio]
    longest = 2.0 * max(facts.extent(body) for body in range(len(facts.scene.bodies)))
    if known and (border := beyond("damped_waves", known[0], longest)):
        yield worded(border, "solver.transfer", longest, f"{solver.transfer}: the longest wave of a body,")


@rule("mpm")
def lost_spin(facts):
    """Rotation, which transfers without an affine part damp."""
    solver = facts.scene.solver
    if not TRANSFERS[solver.transfer].affine:
        ratio = solver.flip_ratio if TRANSFERS[solver.transfer].flip else 0.0
        if border := beyond("lost_spin", solver.transfer, ratio):
            yield worded(border, "solver.transfer", ratio, f'"{solver.transfer}" with flip_ratio')


@rule("mpm")
def cell_crossing(facts):
    """Jumps of the stress when a particle crosses into the next cell."""
    solver = facts.scene.solver
    basis = "cubic shape" if solver.kernel == "cubic" else f"{solver.kernel} {solver.gradient}"
    if border := beyond("cell_crossing", basis, 1.0 / facts.per_axis):
        yield worded(border, "solver.particles_per_cell", 1.0 / facts.per_axis)


@rule("mpm")
def of_comparison(facts):
    """Averaged hats, which are there to be compared with."""
    kernel = facts.scene.solver.kernel
    if box := BASES[kernel].box:
        yield Caution("", "solver.kernel", f'"{kernel}" is for comparison: the linear hat averaged over {box:g} cells,'
                      " however particles deform, in shorter steps than those of a spline",
                      'kernel = "quadratic", the hat averaged over a whole cell, for results')


@rule("mpm")
def numerical_fracture(facts):
    """Numerical fracture of stretched bodies. The stretch of a scene is unknown beforehand, but with one particle a
    cell any stretch tears."""
    if facts.per_axis < 1.5 and facts.scene.solver.kernel == "quadratic":
        border = shipped()["numerical_fracture", "quadratic 1"]
        if border.failing(border.lowest):
            yield worded(border, "solver.particles_per_cell", border.lowest)

"""Rules: materials and layers for which the grid is too coarse."""

from dataclasses import replace

import numpy as np

from snowmpm.advice.cautions.caution import beyond, rounded_down, rule, worded
from snowmpm.advice.refinement import refined, within_reach
from snowmpm.amounts import large, long_time
from snowmpm.components import carried
from snowmpm.measured.borders import shipped

AFLIP = 'solver.transfer = "aflip", flip_ratio = 0.99 and '
VISCOUS = 0.09
"""Growth of friction with the rate from which on mu(I) counts as in the atlas: grains of a thirteenth of the depth,
mu from 0.5 to 0.76, I_0 = 0.279."""
DRAWN_CELLS = 2.0
"""Cells across a weak layer of which a single row collapses first; with more cells, the fracture energy falls."""

SEEDED = 0.95
"""Depth of a layer as it is filled on other cells, over its depth now, at least."""


@rule("mpm")
def volumetric_locking(facts):
    """Too stiff a response of nearly incompressible or dilating snow with many particles a cell (locking)."""
    solver = facts.scene.solver
    many = solver.kernel == "quadratic" and solver.gradient == "affine" and facts.per_axis > 2.5
    for name, law in zip(facts.scene.materials, facts.model.laws, strict=True):
        ratio = law.bulk_modulus / law.shear_modulus
        if border := beyond("volumetric_locking", f"{facts.spline} {9 if many else 4}", ratio):
            nu = (3.0 * border.value - 2.0) / (6.0 * border.value + 2.0)
            what = f"{law.poisson_ratio:g} (border {nu:.3f}): K / G"
            yield worded(border, f"materials.{name}.poisson_ratio", ratio, what)


@rule("mpm")
def stiffness_contrast(facts):
    """A stiff body on a soft one within a cell or two."""
    for pair in facts.pairs:
        if pair.distance == 0 and not pair.separate:
            first, second = (facts.law(body).youngs_modulus for body in (pair.first, pair.second))
            contrast = max(first, second) / min(first, second)
            setting = "cubic" if facts.scene.solver.kernel == "cubic" else (
                "shape" if facts.scene.solver.gradient == "shape" else "quadratic")
            if border := beyond("stiffness_contrast", setting, contrast):
                names = " and ".join(facts.scene.bodies[body].name for body in (pair.first, pair.second))
                yield worded(border, f"bodies ({names})", contrast)


@rule("mpm")
def thin_layer(facts):
    """A soft layer between stiffer bodies, by the contrast to the softest of them."""
    for body, spec in enumerate(facts.scene.bodies):
        if carried(facts.scene, spec):
            continue
        others = [pair.second if pair.first == body else pair.first for pair in facts.pairs
                  if body in (pair.first, pair.second) and pair.distance == 0]
        own = facts.law(body).youngs_modulus
        stiffer = [facts.law(other).youngs_modulus / own for other in others if facts.law(other).youngs_modulus > own]
        if not stiffer:
            continue
        known = {5.0: "1 : 5", 20.0: "1 : 20" if facts.spline == "quadratic" else f"1 : 20 {facts.spline.split()[-1]}"}
        for contrast, setting in sorted(known.items(), reverse=True):
            if min(stiffer) >= contrast:
                if border := beyond("thin_layer", setting, facts.thickness(body)):
                    yield worded(border, f"bodies.{body} ({spec.name})", facts.thickness(body))
                break


@rule("mpm")
def softening_on_grid(facts):
    """A softening weak layer without a reference thickness, whose fracture energy depends on the grid. On the grid of
    the calibration this is correct, so the rule warns only of layers with more cells than collapse as one."""
    for body, spec in enumerate(facts.scene.bodies):
        law = facts.scene.materials[spec.material]
        if law.collapses and law.collapse_thickness is None and not carried(facts.scene, spec):
            border = shipped()["softening_on_grid", "as given"]
            ratio = DRAWN_CELLS / facts.thickness(body)
            if border.failing(ratio):
                yield worded(border, f"materials.{spec.material}.reference_thickness", ratio,
                          f"{facts.thickness(body):.3g} cells through the layer, of which single rows collapse;"
                          " spacing over that of two cells")


@rule("mpm")
def shallow_flow(facts):
    """Layers of snow that may slide on the ground, by their depth at the start."""
    if border := too_shallow(facts):
        found = worded(border, "solver.dx", facts.model.depth / facts.dx)
        yield replace(found, cure=_deep_enough(facts, _setting(facts)))


def too_shallow(facts):
    """The border of `shallow_flow` that the depth of the layers at the start is beyond; None where there is none."""
    if facts.scene.solver.method != "mpm" or not any(body.shape.kind == "layer" for body in facts.scene.bodies):
        return None
    depth = facts.model.depth / facts.dx
    # None where all of it lies over the end of the ground
    return beyond("shallow_flow", _setting(facts), depth) if depth > 0.0 else None


def _setting(facts):
    name = facts.scene.solver.transfer
    return {"aflip": "aflip 0.99", "flip": "flip 0.99"}.get(name, name)


def _deep_enough(facts, own):
    """Settings that put enough cells over the depth, with their cost, if it is affordable."""
    known = {name: shipped()["shallow_flow", name].value for name in ("aflip 0.99", own)}
    fine = {name: rounded_down(SEEDED * facts.model.depth / cells) for name, cells in known.items() if cells}
    said = [f"{AFLIP if name != own else ''}solver.dx = {dx:g}, about {long_time(refined(facts, dx)[0])}"
            for name, dx in fine.items() if within_reach(facts, dx)]
    if said:
        return "; or as it is ".join(said)
    dx = max(fine.values())
    seconds, memory = refined(facts, dx)
    return (f"solver.dx = {dx:g} would resolve it, but is out of reach: about {long_time(seconds)} and {large(memory)}"
            " of memory; take its run-out and speeds for those of a layer that slides, and compare two grids")


@rule("mpm", "sph")
def unstable_friction(facts):
    """Layers of grains with a dilation angle below the friction angle that may slide on the ground, by their depth at
    the start. SPH errs as the affine transfer does: 56 % too fast on 40 cells."""
    solver = facts.scene.solver
    for body, spec in enumerate(facts.scene.bodies):
        if spec.shape.kind != "layer" or not facts.law(body).friction_exceeds_dilation:
            continue
        setting = "mu(I)" if _viscous(facts.law(body), facts.model.depth) else _damping(solver)
        if border := beyond("unstable_friction", setting, facts.model.depth / facts.dx):
            yield worded(border, f"bodies.{body} ({spec.name})", facts.model.depth / facts.dx)


def _viscous(law, depth):
    """Whether friction grows with the rate as much as in the atlas: b d / H sqrt(rho_s / rho), b = (mu_2 - mu_s) / I_0,
    the viscosity over that of the depth [m] and of free fall through it."""
    if law.kind not in ("mu_i", "mu_phi_i"):
        return False
    slope = (law.limit_friction - law.static_friction) / law.inertial_number
    return slope * law.grain_diameter / depth * np.sqrt(law.grain_density / law.density) >= VISCOUS


def _damping(solver):
    """Setting of the atlas with the numerical viscosity of a solver, or the next lower one."""
    if solver.method == "sph":
        return "apic"
    if solver.transfer in ("aflip", "flip"):
        return f"{solver.transfer} 0.99"
    if solver.kernel == "cubic":
        return "cubic"
    cfl = solver.cfl or 1.0
    return "apic, cfl 0.1" if cfl <= 0.1 else "apic, cfl 0.2" if cfl <= 0.2 else "apic"

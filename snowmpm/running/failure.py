"""The entry of the atlas of failures that an unstable run resembles, from the extremes of its last good step."""

import math

import numpy as np

from snowmpm.measured.borders import shipped
from snowmpm.running.audit import occupied_and_emptied

TORN = 0.05
"""Share of emptied cells above which a body counts as torn."""


def diagnose(chosen, solver, dt, more=()):
    """One line: the known failure that the failure of a step of dt [s] resembles, and its cure; None if there is none.

    chosen: the scene's table `solver`; solver: with the extremes of its last good step; more: functions like those of
    SYMPTOMS, of components.
    """
    # No failures are known of a method without a row
    for look in (*more, *SYMPTOMS.get(chosen.method, ())):
        found = look(chosen, solver, dt)
        if found:
            border, value = found
            unit = f" {border.unit}" if border.unit else ""
            limit = f", border {border.value:.3g}{unit}" if border.value is not None else ""
            return (f'looks like "{border.entry}" of the atlas of failures ({border.in_a_sentence}:'
                    f" {border.parameter} {value:.3g}{unit}{limit}); cured by: {border.cure}")
    return None


def first_beyond(entry, settings, value):
    """(border, value) if one of the settings of an entry fails at this value."""
    for setting in settings:
        border = shipped().get((entry, setting))
        if border is not None and math.isfinite(value) and border.failing(value):
            return border, value
    return None


def _crossing(chosen, solver, dt):
    return first_beyond("crossing_step", [chosen.kernel], solver.extremes.speed * dt / solver.frame.dx)


def _deforming(chosen, solver, dt):
    flows = [f"{chosen.transfer} {flow}" for flow in ("collapse", "shear", "expansion")]
    return first_beyond("deformation_step", flows, solver.extremes.gradient * dt)


def _long_step(chosen, solver, dt):
    """C sqrt(s) of the step, scaled from the critical step of the scheme to that of the atlas."""
    border = shipped()["long_step_lone_grain", f"{chosen.kernel} {chosen.gradient} {chosen.transfer}"]
    critical = solver.limits.critical_cfl
    elastic = dt * max(solver.extremes.wave_speed, solver.particles.materials.wave_speed) / solver.frame.dx
    return (border, elastic / critical * border.value) if elastic > critical else None


def _fast(chosen, solver, dt):
    """Speeds near the wave speed, with steps near the critical one."""
    near = dt > 0.5 * solver.critical_dt()[0]
    speed = solver.extremes.speed / solver.particles.materials.wave_speed
    return first_beyond("fast_impact", ["elastic step 0.8"], speed) if near else None


def _near_apex(chosen, solver, dt):
    if not solver.unconverged:
        return None
    return first_beyond("apex", ["cap, frozen", "cap, implicit"], solver.extremes.gradient * dt)


def _torn(chosen, solver, dt):
    cells = (solver.particles.positions() - solver.frame.origin) / solver.frame.dx
    occupied, emptied, _ = occupied_and_emptied(cells[np.isfinite(cells).all(axis=1)])
    if emptied < TORN * max(1, occupied):
        return None
    stretch = float(np.nanmax(solver.particles.column("volume_ratio")))
    return first_beyond("numerical_fracture", [f"{chosen.kernel} 2"], stretch)


def _noisy(chosen, solver, dt):
    return first_beyond("null_space_noise", [chosen.transfer], chosen.flip_ratio)


def _unlike(chosen, solver, dt):
    moduli = [law.youngs_modulus for law in solver.particles.materials.laws]
    return first_beyond("stiffness_contrast", ["quadratic"], max(moduli) / min(moduli))


def _into_walls(chosen, solver, dt):
    return first_beyond("sph_wall", ["mirrored"], solver.extremes.speed / solver.particles.materials.wave_speed)


def _clumping(chosen, solver, dt):
    """Tension over the stiffness of the first material."""
    stress = solver.particles.column("stress")
    law = solver.particles.materials.laws[0]
    pulled = float(np.nanmax(stress[:, :3].sum(axis=1))) / 3.0 / (law.density * law.wave_speed() ** 2)
    return first_beyond("sph_tensile", ["wendland c6 1.5"], pulled)


SYMPTOMS = {
    "mpm": (_crossing, _deforming, _long_step, _fast, _near_apex, _torn, _noisy, _unlike),
    "sph": (_into_walls, _near_apex, _clumping),
    "depth": (),
    "implicit": (),
}
"""Failures by method, in the order of the search: those of a single step before those of the scheme in the long run."""

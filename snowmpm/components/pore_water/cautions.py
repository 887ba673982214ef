"""Rules: steps and splits of pore water, and flow that Darcy's law does not describe."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, beyond, rule, worded
from snowmpm.components.pore_water.step import FilledPores, PoreWater
from snowmpm.running.failure import first_beyond
from snowmpm.schemes import TRANSFERS
from snowmpm.water.permeability import NUMBER, law_of

LARGEST_REYNOLDS = 10.0
"""Of grains, up to which Darcy's law holds (Bear 1972, Dynamics of Fluids in Porous Media, section 5.3)."""

MOLTEN = 0.1
"""Share of the ice in a cell whose melt, which the grains do not lose, is told."""

SOAKING = ("mpm", "implicit")


def undrained(chosen, solver, dt):
    """`contract.Component.symptom`: steps beyond those of undrained waves, where the split has to follow these."""
    water = _water(solver)
    if not isinstance(water, PoreWater) or water.share > 0.0:
        return None
    return first_beyond("undrained_step", ["explicit"], dt / solver.critical_dt()[0])


def _water(solver):
    return next(one for one in solver.adapters if isinstance(one, FilledPores))


@rule(*SOAKING)
def coupling(facts):
    """Steps too long for the coupling of water and skeleton, or shorter than they need be."""
    water, solver = facts.scene.water, facts.solver
    if water is None or water.scheme != "u_p":
        return
    if water.solved:
        border = beyond("weak_alpha", water.split, 2.0 * water.alpha) if water.split == "fixed_stress" else None
        if border:
            yield worded(border, "water.alpha", 2.0 * water.alpha)
        return
    critical = solver.critical_elastic_dt()
    if water.split == "explicit":
        factor = critical * solver.limits.cfl / solver.limits.critical_cfl / solver.stable_dt()[0]
        if factor > 1.5:
            yield Caution("undrained_step", "water.split", f"explicit steps follow waves in undrained snow and are"
                          f" {factor:.3g} times shorter than they need be", 'water.split = "semi_implicit"')
        return
    size = (facts.scene.solver.dt or solver.stable_dt()[0]) / critical
    setting = "apic" if TRANSFERS[facts.scene.solver.transfer].affine else "pic"
    if border := beyond("soaked_step", setting, size):
        yield worded(border, "solver.dt" if facts.scene.solver.dt else "solver.cfl", size)


@rule("implicit")
def undamped_water(facts):
    """Waves in the water that steps with inertia neither follow nor damp."""
    solved = facts.scene.solver.implicit
    if facts.scene.water and solved and solved.time == "newmark" and solved.damping == 0.0:
        yield Caution("", "solver.implicit.damping", "swings of what starts suddenly stay: after ten steps, of which"
                      " waves cross seven cells, 13 % of the pressure", "damping = 0.3 (below 3.3 %)")


@rule(*SOAKING)
def drainage(facts):
    """Drainage that reaches less than a cell within the run."""
    water, solver = facts.scene.water, facts.solver
    if water is None or water.scheme != "u_p" or water.suction is not None:
        return
    least = min(law.density * law.wave_speed() ** 2 for law in facts.model.laws)
    mobility = _permeability(facts).max() / water.viscosity
    reach = np.sqrt(least * mobility * facts.scene.end_time) / solver.frame.dx
    if reach < 1.0:
        yield Caution("", "solver.dx", f"by its end the water has drained from {reach:.2g} cells below the surface:"
                      " the grid does not see where it drains", "a finer grid, a longer run, or a sealed surface")


@rule(*SOAKING)
def fast_flow(facts):
    """Water that flows by its weight too fast for Darcy's law."""
    water = facts.scene.water
    if water is None or water.scheme != "u_p" or law_of(water.permeability) == NUMBER:
        return
    size = water.permeability.get("grain_size")
    if size is None:
        return
    speed = _permeability(facts).max() * water.density * facts.gravity / water.viscosity
    reynolds = water.density * speed * size / water.viscosity
    if reynolds > LARGEST_REYNOLDS:
        yield Caution("", "water.permeability", f"saturated flow by its weight has a Reynolds number of {reynolds:.3g},"
                      f" over {LARGEST_REYNOLDS:g}: Darcy's law is too fast for it",
                      "keep to partial saturation, or a smaller grain_size")


@rule("mpm")
def melt(facts):
    """Melt of so much ice that the grains, which keep their mass, should be less by it."""
    for i, event in enumerate(facts.scene.events):
        if event.kind != "melt":
            continue
        lasts = min(event.stop or facts.scene.end_time, facts.scene.end_time) - event.start
        molten = event.rate * max(lasts, 0.0)
        share = molten / (facts.solver.frame.dx * min(law.density for law in facts.model.laws))
        if share > MOLTEN:
            yield Caution("", f"events.{i}.energy_flux", f"{molten:.3g} kg/m2 melt, {100.0 * share:.2g} % of the ice in"
                          " a cell of the surface, which keeps it", "a shorter event, or less flux")


def _permeability(facts):
    """K [m2] at the start, one a material, or of a raster at the particles."""
    water, positions = _water(facts.solver), facts.model.population.positions
    columns = facts.model.population.columns["water"]
    _, some = np.unique(facts.model.population.material, return_index=True)
    if law_of(facts.scene.water.permeability) == "raster":
        some = np.arange(len(positions))
    return water.permeability(positions[some], 1.0 - columns[some, 2])


ICE = 9e9
"""Bulk modulus of ice [Pa] (Petrenko and Whitworth 1999, Physics of Ice, table 3.3: 8.9e9)."""

COMPRESSED = 1e-3
"""Compression of the ice from which on a pressure is doubted: it is taken as rigid."""


@rule(*SOAKING)
def pressure_on_ice(facts):
    """Water at the start under a pressure that compresses the ice of the skeleton."""
    water = facts.scene.water
    if water is None or water.scheme != "u_p":
        return
    key, pressure = "water.pressure", abs(water.pressure)
    if water.table is not None:
        lowest = float(facts.model.population.positions[:, -1].min())
        key, pressure = "water.table", water.density * abs(facts.scene.gravity_vector[-1]) * (water.table - lowest)
    if pressure > COMPRESSED * ICE:
        yield Caution("", key, f"{pressure:.3g} Pa at the start compress ice by {pressure / ICE:.1%}, and the equations"
                      " take grains as rigid", f"below {COMPRESSED * ICE:.0e} Pa they are")

"""Rules: materials whose loss of strength is averaged over a length."""

from dataclasses import replace

from snowmpm.advice.cautions.caution import beyond, rule, worded
from snowmpm.components.nonlocal_averaging.declare import KEY, averaged

ENOUGH = 4.0
"""Cells, or spacings of particles, over the length."""


@rule("mpm", "sph")
def short_average(facts):
    """A length of so few cells that the thickness of the cells that slip adds to it."""
    for name, length in averaged(facts.scene).items():
        if (border := beyond("averaging_on_grid", facts.scene.solver.method, length / facts.dx)):
            yield replace(worded(border, f"materials.{name}.{KEY}", length / facts.dx),
                          cure=f"solver.dx = {length / ENOUGH:.3g} or less, or, where all shear is in bands, a longer"
                          " nonlocal_length with a softening_strain that is shorter in proportion")

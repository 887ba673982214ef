"""Rules: materials whose loss of strength is averaged over a length."""

from snowmpm.advice.cautions.caution import Caution, rule

LEAST = 4.0
"""Cells, or spacings of particles, over the length, where a band takes 14 % more work than it should; on two 54 %
(`docs/softening.md`)."""


@rule("mpm", "sph")
def short_average(facts):
    """A length of so few cells that the thickness of the cells that slip adds to it."""
    for name, law in facts.scene.materials.items():
        length = law.averaging_length
        if length and length < LEAST * facts.dx:
            what = "cells" if facts.scene.solver.method == "mpm" else "spacings"
            yield Caution("", f"materials.{name}.nonlocal_length", f"{length:g} m is less than four {what} of"
                          f" {facts.dx:g} m: a band that softens takes over 14 % too much work, and on two 54 %",
                          f"solver.dx = {length / LEAST:.3g} or less, or a longer nonlocal_length with a"
                          " softening_strain that is shorter in proportion")

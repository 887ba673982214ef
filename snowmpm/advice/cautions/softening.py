"""Rules: materials whose loss of strength is averaged over a length."""

from snowmpm.advice.cautions.caution import Caution, rule

LEAST = 2.0
"""Cells, or spacings of particles, over the length: a band of a row or two counts as one as thick as the length."""


@rule("mpm", "sph")
def short_average(facts):
    """A length of less than two cells, over which bands are as thick as the cells make them."""
    for name, law in facts.scene.materials.items():
        length = law.averaging_length
        if length and length < LEAST * facts.dx:
            what = "cells" if facts.scene.solver.method == "mpm" else "spacings"
            yield Caution("", f"materials.{name}.nonlocal_length", f"{length:g} m is less than two {what} of"
                          f" {facts.dx:g} m: a band that softens takes more work than over the length",
                          f"solver.dx = {0.5 * length:.3g} or less, or a longer nonlocal_length with a softening_strain"
                          " that is shorter in proportion")

"""Rules: slender bodies that bend further than the affine gradient can follow."""

import numpy as np

from snowmpm.advice.cautions.caution import beyond, rule, worded

SLENDER = 5.0
"""Length over thickness from which on beam theory predicts the deflection."""


@rule("mpm")
def bent_beam(facts):
    """Elastic bodies clamped at one end by a side of the domain, by their deflection under their own weight:
    w / t = 3 rho g L^4 / 2 E' t^3 in thicknesses, E' = E / (1 - nu^2)."""
    scene = facts.scene
    if scene.terrain is not None or scene.domain is None or scene.domain.min is None:
        return
    g, sides = abs(scene.gravity_vector[-1]), scene.domain.sides(facts.dim)
    lower, upper = facts.model.lower, facts.model.upper
    for body, spec in enumerate(scene.bodies):
        law, x = facts.law(body), facts.positions(body)
        if law.YIELDS:
            continue
        spacing = facts.dx / facts.per_axis
        length, thickness = np.ptp(x[:, 0]) + spacing, np.ptp(x[:, -1]) + spacing
        held = [sides["x_min"] == "stick" and x[:, 0].min() < lower[0] + facts.dx,
                sides["x_max"] == "stick" and x[:, 0].max() > upper[0] - facts.dx]
        lies = x[:, -1].min() < lower[-1] + facts.dx
        if sum(held) != 1 or lies or length < SLENDER * thickness:
            continue
        modulus = law.youngs_modulus / (1.0 - law.poisson_ratio**2)
        hangs = 1.5 * law.density * g * length**4 / (modulus * thickness**3)
        if border := beyond("bent_beam", "cubic shape" if facts.spline == "cubic shape" else "quadratic", hangs):
            yield worded(border, f"bodies.{body} ({spec.name})", hangs)

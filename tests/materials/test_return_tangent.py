"""The stiffest axis of laws whose flow is not normal: against their own returns, and in closed form."""

import numpy as np
import pytest
from frictional_laws import LAWS, SOIL
from law_suite import DT, steps_of
from parameter_sets import changed

from snowmpm.materials import DruckerPrager, StressUpdate, unpack
from snowmpm.materials.return_tangent import cone_return, stiffest_over_elastic

STRAIN = 1e-7


def steepest(law):
    """Largest tangent over K + 4G/3, at states of small strain that two steps left, along many axes of each."""
    steps, update = steps_of(law), StressUpdate(law)
    near = np.flatnonzero(steps.small & (steps.size <= 1e-3))[:3000]
    start = steps.result("f64")
    h, state, stress = start.h[near], start.state[near], unpack(start.stress[near])
    still = update(h, state, np.zeros_like(stress), DT).stress
    principal = np.linalg.eigh(stress)[1]
    found = 0.0
    for share in ([1, 0, 0], [0, 0, 1], [9, 4, 0], [4, 0, 1], [17, 1, 1], [2, 0, 1]):
        axis = principal @ np.sqrt(np.array(share) / np.sum(share))
        for strain in (STRAIN, -STRAIN):
            moved = update(h, state, strain * axis[:, :, None] * axis[:, None, :], DT).stress
            along = np.einsum("ni,nij,nj->n", axis, unpack(moved - still), axis) / strain
            found = max(found, along.max())
    return found / (law.bulk_modulus + 4.0 / 3.0 * law.shear_modulus)


@pytest.mark.parametrize("name", ["DP sand", "DP dilating", "DP cohesive", "MC sand", "MC cohesive", "MC associated"])
def test_the_bound_is_reached_and_not_exceeded(name):
    """Strains of up to 1e-3 turn the tangent by as much; axes and stresses are a sample."""
    law = LAWS[name]
    assert 0.99 * law.tangent_over_elastic < steepest(law) < 1.001 * law.tangent_over_elastic


def test_no_rate_makes_flow_stiffer_than_the_limit_friction():
    assert steepest(LAWS["mu(I)"]) < LAWS["mu(I)"].tangent_over_elastic


def test_triaxial_compression_in_closed_form():
    """K (1 + 2 alpha / 3) along the axis of a cone that keeps its volume, if no other axis is steeper."""
    K, G, alpha = 1.0, 0.2, 1.2  # -K alpha / 2G = -3: beyond the axis itself
    assert stiffest_over_elastic(K, G, [cone_return(alpha, 0.0)]) == pytest.approx(
        K * (1.0 + 2.0 * alpha / 3.0) / (K + 4.0 / 3.0 * G), rel=1e-12)


def test_associated_flow_softens_every_axis():
    for law in (changed(LAWS["MC cohesive"], dilation_angle=30.0),
                DruckerPrager(**SOIL, friction_angle=30.0, dilation_angle=30.0, cohesion=1e4)):
        assert law.tangent_over_elastic == 1.0

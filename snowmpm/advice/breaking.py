"""When the bonds of a saw test's weak layer break, so that its steps are short: expected from the theories of the test.

    from  t_0 = t_saw + (a_c - notch) / v_saw    the critical cut
    to    t_0 + (L - a_c) / (0.6 c_s)            the crack has crossed the column

a_c: of the energy theory, with the plastic work that breaks all bonds (`Law.bond_energy`) over the thickness of the
layer; c_s: shear waves of the slab, of which flat cracks reach 0.6 (Bobillier et al. 2024). Other scenes with a weak
layer break it in a small part of their time, which is left out.
"""

from snowmpm.saw_test import theory
from snowmpm.saw_test.prediction import column_of


def breaking_between(scene):
    """(begin, end) [s] between which bonds are expected to break; (0, 0) in a scene without a saw test or without
    gravity, or if the weak layer keeps its bonds."""
    test = scene.saw_test
    if test is None or not scene.gravity or column_of(scene)[1].bond_energy <= 0.0:
        return 0.0, 0.0
    slab, law, thickness = column_of(scene)
    energy = law.bond_energy * (law.collapse_thickness or thickness)
    load = slab.stresses(test.slope_angle, scene.gravity)
    sawn = 0.5 * test.length if test.saw_length is None else test.saw_length
    cut = max(test.notch, min(sawn, theory.critical_length_by_energy(slab, *load, energy, test.ends)))
    begin = test.saw_start + (cut - test.notch) / test.saw_speed
    return begin, begin + (test.length - cut) / (theory.SHARE_OF_SHEAR_SPEED * slab.shear_speed)

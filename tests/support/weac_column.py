"""A saw test on an elastic weak layer by WEAC, in its units and with its signs."""

import pytest

from snowmpm.study.problems.elastic_saw_test import LENGTH

weac = pytest.importorskip("weac", reason="WEAC is in the extra peers")

STIFFNESSES = 0.5e6 / 2.6 / 0.05, 0.5e6 / 0.91 / 0.05  # Pa/m, of WEAC: shear, G / t; normal, E / (1 - nu^2) / t


def of_weac(cut, slope_angle, length=LENGTH):
    """Energy release rate [J/m2] and deflection of the free end [mm] by WEAC."""
    model = weac.Layered(system="pst-", touchdown=False)
    model.set_foundation_properties(t=50.0, E=0.5, nu=0.3, update=False)
    # Its modulus is C0 (rho / 917)^C1 [GPa]
    model.set_beam_properties([[250.0, 500.0]], C0=3e-3, C1=0.0, nu=0.3, update=True)
    angle = -slope_angle
    parts = model.calc_segments(L=1e3 * length, a=1e3 * cut, m=0, phi=angle)["crack"]
    li, mi, ki = (parts[name] for name in ("li", "mi", "ki"))
    C = model.assemble_and_solve(phi=angle, li=li, mi=mi, ki=ki)
    rate = model.gdif(C, angle, li=li, ki=ki)[0]
    _, z, _ = model.rasterize_solution(C=C, phi=angle, li=li, ki=ki)
    return 1e3 * rate, model.w(z)[-1]

"""Critical length by WEAC, a Timoshenko beam on an elastic weak layer, where it is installed.

Rosendahl & Weissgraeber (2020), doi:10.5194/tc-14-115-2020; the package `weac`, version 2. It has no strength: the
crack runs when the energy release rate reaches the work of collapse. Ends, layers of the slab and gravity are those of
the scene. WEAC's slabs of several layers are stiffer in shear than `theory.Slab` (reason there).
"""

import math

from snowmpm.saw_test.prediction import column_of

SYSTEMS = {"normal": "pst-", "vertical": "vpst-"}
"""WEAC's name for a column by its ends, cut from the right."""

LONGEST = 0.9
"""Share of the column: the longest cut tried."""

TRIES = 30
"""Number of bisections for the critical length."""


def critical_length(scene, energy):
    """[m], for a work of collapse [J/m2]; None without the package, or where no cut in the column is enough."""
    try:
        import weac
    except ImportError:
        return None
    if not hasattr(weac, "Layered"):
        return None
    test = scene.saw_test
    _, law, thickness = column_of(scene)
    model = weac.Layered(system=SYSTEMS[test.ends], touchdown=False)
    model.g = 1e3 * scene.gravity  # its lengths are in mm
    model.set_foundation_properties(t=1e3 * thickness, E=1e-6 * law.youngs_modulus, nu=law.poisson_ratio, update=False)
    layers = [(scene.materials[layer.material], 1e3 * layer.thickness) for layer in reversed(test.slab)]
    model.set_beam_properties([[law.density, height] for law, height in layers], update=False)
    # It derives moduli from densities: replace them by those of the laws, in MPa
    model.slab[:, 2:] = [[1e-6 * law.youngs_modulus, 1e-6 * law.shear_modulus, law.poisson_ratio] for law, _ in layers]
    model.calc_fundamental_system()
    angle = -test.slope_angle  # it cuts from the right, with the angle of opposite sign

    def release_rate(cut):
        parts = model.calc_segments(L=1e3 * test.length, a=1e3 * cut, m=0, phi=angle)["crack"]
        lengths = {name: parts[name] for name in ("li", "ki")}
        solved = model.assemble_and_solve(phi=angle, mi=parts["mi"], **lengths)
        return 1e3 * model.gdif(solved, angle, **lengths)[0]

    lower, upper = 0.0, LONGEST * test.length
    if not release_rate(upper) > energy:
        return None
    for _ in range(TRIES):
        middle = 0.5 * (lower + upper)
        lower, upper = (lower, middle) if release_rate(middle) > energy else (middle, upper)
    return upper if math.isfinite(upper) else None

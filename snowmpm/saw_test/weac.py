"""Critical length by WEAC, a Timoshenko beam on an elastic weak layer, where it is installed.

Rosendahl & Weissgraeber (2020), doi:10.5194/tc-14-115-2020; the package `weac`, version 2 or 3. It has no strength: the
crack runs when the energy release rate reaches the work of collapse. Ends, layers of the slab and gravity are the
caller's. WEAC's slabs of several layers are stiffer in shear than `theory.Slab` (reason there).
"""

import functools

from snowmpm.saw_test.prediction import column_of

SYSTEMS = {"normal": "pst-", "vertical": "vpst-"}
"""WEAC's name for a column by its ends, cut from the right."""

LONGEST = 0.9
"""Share of the column: the longest cut tried."""

TRIES = 30
"""Number of bisections for the critical length."""

GRAVITY = 9.81
"""Of version 3, which has no other [m/s2]."""


@functools.cache
def version():
    """2 or 3, of the package that is installed; None without one."""
    try:
        import weac
    except ImportError:
        return None
    if hasattr(weac, "Layered"):
        return 2
    try:
        import weac.core.system_model
    except ImportError:
        return None
    return 3


def critical_length(scene, energy):
    """[m], for a work of collapse [J/m2] of a scene; None without the package, or where no cut in the column is enough.
    """
    test = scene.saw_test
    _, law, thickness = column_of(scene)
    layers = [(layer.thickness, scene.materials[layer.material]) for layer in test.slab]
    return critical_length_of(layers, law, thickness, slope_angle=test.slope_angle, length=test.length, ends=test.ends,
                              energy=energy, gravity=scene.gravity)


def critical_length_of(layers, weak, thickness, *, slope_angle, length, ends, energy, gravity=GRAVITY):
    """[m], for a work of collapse [J/m2]; None without the package, or where no cut in the column is enough.

    layers: [(thickness [m], law)] from the weak layer up; weak: law of the weak layer, `thickness` [m] thick; a law has
    density, youngs_modulus, poisson_ratio and shear_modulus. slope_angle [degrees], positive: the saw cuts upslope;
    length: of the column [m]; ends: a key of SYSTEMS; gravity [m/s2].
    """
    makers = {2: _release_rate_2, 3: _release_rate_3}
    if version() is None or (version() == 3 and gravity != GRAVITY):
        return None
    release_rate = makers[version()](layers, weak, thickness, -slope_angle, length, ends, gravity)
    lower, upper = 0.0, LONGEST * length
    if not release_rate(upper) > energy:
        return None
    for _ in range(TRIES):
        middle = 0.5 * (lower + upper)
        lower, upper = (lower, middle) if release_rate(middle) > energy else (middle, upper)
    return upper


def _release_rate_2(layers, weak, thickness, angle, length, ends, gravity):
    """Function of a cut [m]: energy release rate [J/m2], by version 2. angle: it cuts from the right, with the angle of
    opposite sign [degrees]."""
    import weac

    model = weac.Layered(system=SYSTEMS[ends], touchdown=False)
    model.g = 1e3 * gravity  # its lengths are in mm
    model.set_foundation_properties(
        t=1e3 * thickness, E=1e-6 * weak.youngs_modulus, nu=weak.poisson_ratio, update=False)
    model.set_beam_properties([[law.density, 1e3 * height] for height, law in reversed(layers)], update=False)
    # It derives moduli from densities: replace them by those of the laws, in MPa
    model.slab[:, 2:] = [[1e-6 * law.youngs_modulus, 1e-6 * law.shear_modulus, law.poisson_ratio]
                         for _, law in reversed(layers)]
    model.calc_fundamental_system()

    def release_rate(cut):
        parts = model.calc_segments(L=1e3 * length, a=1e3 * cut, m=0, phi=angle)["crack"]
        lengths = {name: parts[name] for name in ("li", "ki")}
        solved = model.assemble_and_solve(phi=angle, mi=parts["mi"], **lengths)
        return 1e3 * model.gdif(solved, angle, **lengths)[0]

    return release_rate


def _release_rate_3(layers, weak, thickness, angle, length, ends, gravity):
    """The same by version 3."""
    from weac.analysis.analyzer import Analyzer
    from weac.components import Config, Layer, ModelInput, ScenarioConfig, Segment
    from weac.components import WeakLayer as Foundation
    from weac.core.system_model import SystemModel

    beam = [Layer(rho=law.density, h=1e3 * height, E=1e-6 * law.youngs_modulus, G=1e-6 * law.shear_modulus,
                  nu=law.poisson_ratio) for height, law in reversed(layers)]
    foundation = Foundation(rho=weak.density, h=1e3 * thickness, E=1e-6 * weak.youngs_modulus, nu=weak.poisson_ratio,
                            collapse_height=0.5e3 * thickness)  # of touchdown, which is off; its own may be refused

    def parts(cut):
        return ScenarioConfig(system_type=SYSTEMS[ends], phi=angle, cut_length=1e3 * cut), [
            Segment(length=1e3 * (length - cut), has_foundation=True, m=0),
            Segment(length=1e3 * cut, has_foundation=False, m=0)]

    scenario, segments = parts(0.5 * length)
    model = SystemModel(ModelInput(weak_layer=foundation, scenario_config=scenario, layers=beam, segments=segments),
                        Config(touchdown=False))

    def release_rate(cut):
        scenario, segments = parts(cut)
        model.update_scenario(segments=segments, scenario_config=scenario)
        return float(Analyzer(model).differential_ERR(unit="J/m^2")[0])

    return release_rate

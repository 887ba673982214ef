"""Density, stiffness and strength of snow layers by published parametrisations.

Each has a source and a range. Their scatter is large, and larger between laws of one quantity than within each: the
modulus at one density differs by a factor of ten to forty between laws, since frequency and method of the measurement
decide. What is computed from a profile names its law, and takes the scatter along (`stability`).
"""

import math

from snowmpm.pit.profile import ICE_DENSITY, LIGHTEST, Layer
from snowmpm.quantities.snow_codes import is_crust, main_class

BY_HARDNESS = {
    "PP": (45.0, 36.0), "PPgp": (83.0, 37.0), "DF": (65.0, 36.0), "RGxf": (91.0, 42.0), "FC": (112.0, 46.0),
    "FCxr": (56.0, 64.0), "DH": (185.0, 25.0),
}
"""Form: A, B of the density A + B h [kg/m3], h the index of hand hardness. Geldsetzer & Jamieson (2000), International
Snow Science Workshop 2000, 121-127; for rounded grains 154 + 1.51 h^3.15. RGxf and FCxr are their mixed forms."""
GRAIN_SIZE = {"PP": 1.0, "DF": 0.75, "RG": 0.4, "FC": 1.25, "DH": 2.0, "SH": 4.0, "MF": 1.0}
"""Of a class, where it was not measured [mm]: chosen."""
BY_FORM = {"PP": 85.0, "PPgp": 162.0, "DF": 136.0, "RG": 247.0, "RGxf": 221.0, "FC": 248.0, "FCxr": 289.0, "DH": 253.0,
           "MFcr": 292.0, "SH": 125.0, "MF": 317.0, "IF": 700.0, "MM": 350.0}
"""Density of a form where the hardness is not known, or does not tell [kg/m3]: means of Geldsetzer & Jamieson; MF
between the limits for index 2 and 3 of Monti et al. (2014), doi:10.1016/j.coldregions.2014.04.001; SH as WEAC takes it;
IF and MM chosen."""
BY_HARDNESS_ALONE = 90.0, 42.0
"""A, B of a density where the form is not known [kg/m3]: mean of the lines of BY_HARDNESS and of rounded grains."""
DENSITY_SCATTER = {"hardness": 0.29, "form": 0.32, "hardness alone": 0.34, "measured": 0.05}
"""Standard deviation of the logarithm of a density, by where it is from. hardness, form, hardness alone: of 3659, 5103
and 5340 layers of public pits that have a measured density as well (`snowmpm docs snow_pits`), by the median deviation,
as some have slips of the pen; measured: of density cutters, Proksch et al. (2016), doi:10.5194/tc-10-371-2016."""

POISSON_RATIO = 0.25
"""As WEAC has it."""

MODULI = {
    "bergfeld": ("Bergfeld et al. (2023), doi:10.5194/nhess-23-293-2023: whole slabs in saw tests",
                 lambda rho: 6.5e9 * (rho / ICE_DENSITY) ** 4.4),
    "scapozza": ("Scapozza (2004), doctoral thesis, ETH Zürich: slow compression in the laboratory",
                 lambda rho: 5.07e9 * (rho / ICE_DENSITY) ** 5.13),
    "gerling": ("Gerling et al. (2017), doi:10.1002/2017GL075110: waves and tomography",
                lambda rho: 6e-4 * rho**4.6),
    "van_herwijnen": ("van Herwijnen et al. (2016), doi:10.1017/jog.2016.90: slabs in saw tests",
                      lambda rho: 0.1873e6 * math.exp(0.0149 * rho)),
}
"""Name: source, and Young's modulus [Pa] of a density [kg/m3]."""
USUAL_MODULUS = "bergfeld"
LIGHT, DENSE = 50.0, 500.0
"""Densities [kg/m3] between which the laws are taken; beyond, their value there."""

SHEAR_STRENGTH = {"PP": (2.85e3, 1.13), "DF": (8.75e3, 1.54), "RG": (7.39e3, 1.20), "MF": (21e3, 1.24),
                  "FC": (18.5e3, 2.11), "DH": (18.5e3, 2.11), "SH": (18.5e3, 2.11)}
"""Class: a [Pa] and exponent of the shear strength a (rho / 917)^b: Jamieson & Johnston (2001),
doi:10.3189/172756401781819472, of shear frames. Surface hoar, whose strength hardly follows its density, is taken as
faceted crystals."""
STRENGTH_SCATTER = 0.35
"""Standard deviation of the logarithm of a shear strength: chosen, of the scatter in Jamieson & Johnston's figures."""

COLLAPSE = 0.56
"""Specific fracture energy in compression [J/m2], as WEAC has it."""
COLLAPSE_SCATTER = 0.9
"""Standard deviation of its logarithm: field measurements are from 0.08 to 2.7 J/m2 (van Herwijnen et al. 2016), two
deviations from 0.56 on either side about."""


def density(layer: Layer) -> tuple[float, str] | None:
    """(density [kg/m3], where it is from: a key of DENSITY_SCATTER) of a layer; None where nothing tells it."""
    if layer.density is not None:
        return layer.density, "measured"
    form, hardness = density_form(layer.form or layer.second_form), layer.mean_hardness
    if form in BY_HARDNESS and hardness is not None:
        first, each = BY_HARDNESS[form]
        return first + each * hardness, "hardness"
    if form == "RG" and hardness is not None:
        return 154.0 + 1.51 * hardness**3.15, "hardness"
    if form:
        return BY_FORM[form], "form"
    if hardness is not None:
        first, each = BY_HARDNESS_ALONE
        return first + each * hardness, "hardness alone"
    return None


def density_form(code: str) -> str:
    """The form of BY_FORM that a code belongs to; "" for none."""
    if code in BY_FORM:
        return code
    if is_crust(code):
        return "IF" if main_class(code) == "IF" else "MFcr"
    return main_class(code)


def youngs_modulus(rho: float, law: str = USUAL_MODULUS) -> float:
    """[Pa] of a density [kg/m3]. law: a key of MODULI."""
    return MODULI[law][1](min(max(rho, LIGHT), DENSE))


def shear_strength(layer: Layer, rho: float) -> float | None:
    """[Pa] of a weak layer of a density [kg/m3], without load; None for a form that has no law."""
    law = SHEAR_STRENGTH.get(main_class(layer.form or layer.second_form))
    if law is None or is_crust(layer.form):
        return None
    return law[0] * (max(rho, LIGHTEST) / ICE_DENSITY) ** law[1]


def tensile_strength(rho: float) -> float:
    """[Pa]: 240 kPa (rho / 917)^2.44, Sigrist (2006), doctoral thesis, ETH Zürich."""
    return 240e3 * (rho / ICE_DENSITY) ** 2.44


def collapse_height(thickness: float) -> float:
    """[m] of a weak layer [m]: 4.70 mm (1 - exp(-t / 7.78 mm)), van Herwijnen et al. (2016)."""
    return 4.70e-3 * (1.0 - math.exp(-thickness / 7.78e-3))


def softness(rho: float, size: float) -> float:
    """F_wl [m/Pa] = 4.7e-9 (rho / 917 s / 1.25 mm)^-2.1 of a weak layer of grains of `size` [mm]: Richter et al.
    (2019), doi:10.5194/tc-13-3353-2019, Eq. 9, in place of thickness over shear modulus."""
    return 4.7e-9 * (rho / ICE_DENSITY * size / 1.25) ** -2.1

"""A law with a part of its strength: what strength reduction divides by its factor.

    way "tangent": tan phi / f, c / f        way "angle": phi / f, c / f

(Zienkiewicz, Humpheson and Lewis 1975, doi:10.1680/geot.1975.25.4.671, divide tan phi; Peng, Wu, Yu and Wang 2015,
doi:10.1007/s11440-015-0399-3, eqs. 39-40, the angle.) A slope of q over p is divided itself in the first way, and in
the second the angle that it stands for: sin phi = 3 M / (6 + M) for `critical_slope`, tan phi for a friction
coefficient. No law dilates by more than its friction: the dilation angle is at most the reduced friction angle.

Of `cohesive_crack` the cohesion of a crack is divided at every jump, T(u) / f: f_t and, with the same opening at which
none is left, G_f. Its ratio of shear strength to f_t stays. What a law around cracks has of strength counts as its own.
"""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.materials import LAWS, Law

WAYS = ("tangent", "angle")

ANGLES = ("friction_angle", "residual_friction_angle")
COEFFICIENTS = ("static_friction", "limit_friction")
STRESSES = ("cohesion", "residual_cohesion", "yield_stress")
"""[Pa]: of laws with a friction angle, or without friction."""
OF_CRACKS = ("strength", "fracture_energy")
"""[Pa], [J/m2]"""
AROUND = "bulk"
"""Field with the law around the cracks of a law, or None; what it has is named bulk.NAME."""


def strengths(law: Law) -> dict[str, float]:
    """What of a law is strength, by the name of its field; {} for one without."""
    names = [name for name in (*ANGLES, *COEFFICIENTS, "critical_slope", *OF_CRACKS) if law.get(name) is not None]
    if "critical_slope" not in names:  # there cohesion is a share of p0, and falls with the slope
        names += [name for name in STRESSES if law.get(name) is not None]
    around = law.get(AROUND)
    inner = {f"{AROUND}.{name}": value for name, value in strengths(around).items()} if around else {}
    return {**{name: float(law[name]) for name in names}, **inner}


def weakened(law: Law, factor: float, way: str = "tangent") -> Law:
    """The law with its strength divided by a factor. Raises InputError where the law does not allow that."""
    try:
        return LAWS[law.kind].model_validate(_weaker(law, factor, way))
    except ValueError as error:
        reason = str(error).splitlines()[-2 if len(str(error).splitlines()) > 2 else -1].strip()
        raise InputError(f"{law.kind} with its strength divided by {factor:g} is not possible:\n{reason}") from None


def _weaker(law, factor, way):
    """The numbers of a law with its strength divided, as it takes them."""
    around = law.get(AROUND)
    changed = {name: _divided(name, value, factor, way) for name, value in strengths(law).items()
               if name in type(law).model_fields}
    if "friction_angle" in changed and law.get("dilation_angle", 0.0) > changed["friction_angle"]:
        changed["dilation_angle"] = changed["friction_angle"]
    if around:
        changed[AROUND] = _weaker(around, factor, way)
    return {**law.model_dump(exclude={"card", "began_with", "card_source"}), **changed}


def _divided(name: str, value: float, factor: float, way: str) -> float:
    if name in STRESSES or name in OF_CRACKS or (way == "tangent" and name not in ANGLES):
        return value / factor
    if name in ANGLES:
        return value / factor if way == "angle" else float(np.degrees(np.arctan(np.tan(np.radians(value)) / factor)))
    if name in COEFFICIENTS:
        return float(np.tan(np.arctan(value) / factor))
    sine = np.sin(np.arcsin(3.0 * value / (6.0 + value)) / factor)
    return float(6.0 * sine / (3.0 - sine))

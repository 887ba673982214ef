"""The numbers of cracks for Taichi functions, alone or beside those of the law around them."""

import functools
from collections import namedtuple
from typing import Any, NamedTuple


class CohesiveCrackParameters(NamedTuple):
    """What the update of `CohesiveCrack` reads."""

    K: float  # bulk modulus [Pa]
    shear_modulus: float  # G [Pa]
    strength: float  # f_t [Pa]
    friction: float  # μ [-]
    beta: float  # β [-]
    per_beta: float  # 1/β [-]
    per_weight: float  # 1/β² [-]
    normal: float  # M w_c/H: fall of t_n per damage [Pa]
    shear: float  # G w_c/H: fall of t_s per damage [Pa]
    normal_per_metre: float  # M/H [Pa/m]
    jump_over_length: float  # w_c/H [-]


@functools.cache
def wrapped_parameters(bulk: type) -> Any:
    """NamedTuple class of `CohesiveCrackParameters` and the numbers of a law of this class of them, as bulk_NAME."""
    own = CohesiveCrackParameters._fields
    return namedtuple(f"Cracked{bulk.__name__}", (*own, *(f"bulk_{name}" for name in bulk._fields)))  # type: ignore

"""Time steps that a scene asks for and that cannot be stable."""

import numpy as np

from snowmpm.errors import InputError


def check_step(scene, solver):
    """Refuse a cfl beyond the critical one of the scheme, and a fixed step that is unstable from the start."""
    chosen, limits = scene.solver, solver.limits
    if chosen.cfl and chosen.cfl > limits.critical_cfl:
        allowed = f"unstable: must be at most {rounded_down(limits.critical_cfl)} for {limits.scheme}"
        raise InputError.at("solver.cfl", chosen.cfl, allowed, scene.source)
    fixed, (limit, cause) = chosen.dt, solver.critical_dt()
    if not limit > 0.0:
        raise InputError(f"{scene.source}: no time step is stable ({cause} limit: {limit} s): the numbers of a material"
                         " or a velocity are out of reach")
    if fixed and fixed > limit:
        allowed = (f"unstable: must be at most {rounded_down(limit)} s here ({cause} limit);"
                   " leave it out for an adaptive step")
        raise InputError.at("solver.dt", fixed, allowed, scene.source)


def rounded_down(limit):
    """A limit in three digits that keeps to itself."""
    scale = 10.0 ** (np.floor(np.log10(limit)) - 2)
    return f"{np.floor(limit / scale * (1.0 + 1e-12)) * scale:.3g}"

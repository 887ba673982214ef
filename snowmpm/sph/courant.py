"""How long a step may be, as a Courant number C = c dt / dx."""

USUAL, USUAL_SHARE = 0.3, 0.8
"""C of a scene that gives none: dt = 0.2 h / c at h = 1.5 dx, that of Favero Neto & Borja, or this share of the
critical one where that is less."""


def critical_cfl(viscosity, disorder_damping):
    """Largest stable C = c dt / dx: 0.9 of waves, less where explicit damping becomes too strong, 0.9 / (0.64 alpha +
    1.22 gamma). Measured on free elastic blocks of disordered particles, in steps of 0.2: at alpha, gamma = 0.1, 0.5
    stable to 1.1 in 2-D, at 1.0, 0.5 to 0.7, at 0.1, 2.0 to 0.3; in 3-D to 0.9, 0.9, 0.5."""
    return min(0.9, 0.9 / max(0.64 * viscosity + 1.22 * disorder_damping, 1e-9))


def usual_cfl(critical):
    """C that a scene without one gets, of the critical one."""
    return min(USUAL, USUAL_SHARE * critical)

"""What the skeleton of wet snow bears at the ground, for friction: the weight less the pressure in its pores."""

from snowmpm.compiler import ti

EFFECTIVE, LOAD, DRAINED, BUOYANT, OVERBURDEN, WATER, NOW, LIGHTNESS = range(8)
"""Numbers of a column: effective stress at the ground [Pa] and W [Pa] as of the last step, whether its ground is
drained, rho' of W = rho' N h [kg/m3], u [-], density of water times d / h [kg/m3], W of this step,
density of water over that of the mixture around a column of one phase (`two_phase`). Before the first step W is
below 0 and EFFECTIVE the share of W that the skeleton bears."""
PORE = 8


@ti.func
def effective_stress(pore, total, load):
    """Normal stress that the skeleton gives to the ground [Pa], without drainage since the last step.

    total: normal stress [Pa]; load: W now [Pa]. Between 0, liquefied, and the total stress, without pore pressure."""
    stress = pore[EFFECTIVE] + pore[DRAINED] * (load - pore[LOAD])
    if pore[LOAD] < 0.0:
        stress = load * ti.max(pore[DRAINED], pore[EFFECTIVE])
    return ti.min(total, ti.max(0.0, stress))

"""Velocity conditions at grid nodes that lie inside the ground or beyond a side of the domain.

    stick:     v = v_wall
    slip:      v_n = 0, tangential part kept but for Coulomb friction
    separate:  as slip where the node approaches the wall (v_n < 0), free where it leaves

Coulomb: the tangential velocity is shortened by mu |dv_n|, dv_n the normal velocity towards the wall that was taken
away, never reversed (Bardenhagen, Brackbill & Sulsky 2000, doi:10.1016/S0045-7825(99)00338-2). What a wall that slips
holds back from leaving has no friction.
"""

from snowmpm.compiler import ti

OPEN, STICK, SLIP, SEPARATE = range(4)
CODES = {"open": OPEN, "stick": STICK, "slip": SLIP, "symmetric": SLIP, "separate": SEPARATE}


@ti.func
def contact_velocity(v, normal, code, friction):
    """Velocity of a constrained node; normal: unit vector out of the wall; friction: Coulomb mu [-]."""
    result = v
    if code == STICK:
        result = v * 0.0
    elif code != OPEN:
        v_n = v.dot(normal)
        if code == SLIP or v_n < 0.0:
            tangential = v - v_n * normal
            speed = tangential.norm()
            kept = ti.max(0.0, speed - friction * ti.max(0.0, -v_n))
            result = tangential * (kept / ti.max(speed, 1e-30))
    return result

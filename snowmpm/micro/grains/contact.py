"""The contact of two spheres.

With the overlap d = r_i + r_j - |x_i - x_j|, the unit normal n from j to i and the velocity u of i relative to j where
they touch,

    normal      F_n = max(0, k_n d - c_n u.n) n
    tangential  F_t = -k_t s - c_t u_t,   |F_t| <= mu F_n:   s' = u_t while it sticks (Cundall and Strack 1979,
                doi:10.1680/geot.1979.29.1.47)
    rolling     M = -k_r theta - c_r omega_t,   |M| <= mu_r R F_n:   theta' = relative rotation without twist

A bond is a cylinder of ice of radius r = min(r_i, r_j), area A = pi r^2, that also pulls, bends and twists:

    normal      F_n = k_n (d - d_0) - c_n u.n;   d_0: overlap at which it is free of force, also once broken, until the
                grains part
    bending     M_b = -(k_n r^2 / 4) theta_b,   twisting M_t = -(k_t r^2 / 2) theta_t

and breaks where -F_n / A + 4 M_b / (A r) > strength, or (|F_t| - mu F_n) / A + 2 M_t / (A r) > shear_strength: the
stresses at its edge by the theory of beams (parallel bond, Potyondy and Cundall 2004,
doi:10.1016/j.ijrmms.2004.09.011).

R = r_i r_j / (r_i + r_j), m the reduced mass. Dashpots c = 2 damping sqrt(k m), in rolling and bending
c_r = 2 damping sqrt(k_r m) R. A free rebound without damping takes pi sqrt(m / k_n). Springs turn with the normal.
"""

from dataclasses import dataclass

from snowmpm.compiler import ti


@dataclass(frozen=True)
class ContactLaw:
    """stiffness k_n, k_t [N/m]; friction mu, rolling mu_r, damping [-]; strength, shear_strength of bonds [Pa].

    rolling_stiffness k_r = k_t R^2 [N m]. Raises ValueError for numbers out of range.
    """

    stiffness: float
    tangential: float
    friction: float = 0.5
    rolling: float = 0.0
    damping: float = 0.1
    strength: float = 0.0
    shear_strength: float = 0.0

    def __post_init__(self):
        for name in ("stiffness", "tangential"):
            if not vars(self)[name] > 0.0:
                raise ValueError(f"{name} = {vars(self)[name]!r}: must be > 0")
        for name in ("friction", "rolling", "damping", "strength", "shear_strength"):
            if not vars(self)[name] >= 0.0:
                raise ValueError(f"{name} = {vars(self)[name]!r}: must be >= 0")

    def numbers(self):
        """As kernels take them: [k_n, k_t, mu, mu_r, damping, strength, shear_strength]."""
        return [self.stiffness, self.tangential, self.friction, self.rolling, self.damping, self.strength,
                self.shear_strength]


@ti.func
def turned(spring, n):
    """A spring in the plane of a contact whose normal is now n, with the length that it had."""
    flat = spring - spring.dot(n) * n
    size = flat.norm()
    return flat * (spring.norm() / size) if size > 0.0 else flat


@ti.func
def limited(force, most):
    """A force, at most so large."""
    size = force.norm()
    return force * (most / size) if size > most else force

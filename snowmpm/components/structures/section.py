"""Cross-section of a rod: stiffness, mass and the moments at which it yields and breaks."""

from dataclasses import dataclass

import numpy as np

from snowmpm.keys import Keyed


@dataclass(frozen=True)
class Section(Keyed):
    """axial E A [N], bending E I [N m2], the same about every axis across; line_mass [kg/m]; yield_moment,
    breaking_moment [N m], infinite where it does not yield or break; hardening: stiffness of a plastic hinge over the
    elastic one [-]; width: of the section across [m], where it breaks. In 2-D per metre of width."""

    axial: float
    bending: float
    line_mass: float
    yield_moment: float = np.inf
    breaking_moment: float = np.inf
    hardening: float = 0.0
    width: float = 0.0

    @property
    def breaking_force(self):
        """Axial force f_b A [N] at which it breaks, of M_b = f_b 2 I / D; infinite where it does not."""
        if np.isinf(self.breaking_moment):
            return np.inf
        return self.breaking_moment * self.width * self.axial / (2.0 * self.bending)

    @property
    def polar_mass(self):
        """rho 2 I [kg m]: moment of inertia about its own axis, by length."""
        return 2.0 * self.line_mass * self.bending / self.axial

    @classmethod
    def tube(cls, width, wall, modulus, density, *, yield_stress=None, strength=None, hardening=0.0):
        """Round tube of outer diameter `width` [m] and thickness `wall` [m], at most width / 2: a full bar.

            A = pi (D^2 - d^2) / 4,  I = pi (D^4 - d^4) / 64,  M_y = f_y (D^3 - d^3) / 6,  M_b = f_b 2 I / D

        E [Pa], density [kg/m3]; f_y yield_stress [Pa]: all of the section yields (plastic moment); f_b strength [Pa]:
        in its outermost fibre.
        """
        inner = width - 2.0 * wall
        area, second = np.pi * (width**2 - inner**2) / 4.0, np.pi * (width**4 - inner**4) / 64.0
        return cls._of(area, second, (width**3 - inner**3) / 6.0, width, modulus, density, yield_stress, strength,
                       hardening)

    @classmethod
    def plate(cls, width, modulus, density, *, yield_stress=None, strength=None, hardening=0.0):
        """Plate of thickness `width` [m], one metre wide: A = t, I = t^3 / 12, M_y = f_y t^2 / 4, M_b = f_b t^2 / 6."""
        return cls._of(width, width**3 / 12.0, width**2 / 4.0, width, modulus, density, yield_stress, strength,
                       hardening)

    @classmethod
    def _of(cls, area, second, plastic, width, modulus, density, yield_stress, strength, hardening):
        return cls(modulus * area, modulus * second, density * area,
                   np.inf if yield_stress is None else yield_stress * plastic,
                   np.inf if strength is None else strength * 2.0 * second / width, hardening, width)

"""What theories say about a propagation saw test. NumPy; lengths [m], stresses [Pa], energies per area [J/m2].

Slab: a plate in plane strain, E' = E / (1 - nu^2), of thickness D; sigma, tau: normal and shear stress that it puts on
the weak layer, sigma > 0 in compression. Slabs of several layers enter by their mean density and the moduli that give
the same stiffness in bending and in stretching.
"""

from dataclasses import dataclass

import numpy as np

GRAVITY = 9.81
SHARE_OF_SHEAR_SPEED = 0.6
"""Largest speed of a flat anticrack over that of shear waves in the slab: Bobillier et al. (2024), up to 0.6."""


@dataclass(frozen=True)
class Slab:
    """thickness D [m], density [kg/m3], moduli [Pa]: bending 12 B / D^3, stretching A / D, both plane strain, shear."""

    thickness: float
    density: float
    bending_modulus: float
    stretching_modulus: float
    shear_modulus: float

    @classmethod
    def of(cls, layers):
        """layers: [(thickness [m], law)] from the weak layer up; B about the neutral axis."""
        d = np.array([thickness for thickness, _ in layers])
        plate = np.array([law.youngs_modulus / (1.0 - law.poisson_ratio**2) for _, law in layers])
        z, total = np.cumsum(d) - 0.5 * d, d.sum()
        neutral = (plate * d) @ z / (plate @ d)
        bending = (plate * (d**3 / 12.0 + d * (z - neutral) ** 2)).sum()
        return cls(float(total), float(d @ [law.density for _, law in layers] / total),
                   float(12.0 * bending / total**3), float(plate @ d / total),
                   float(total / (d / [law.shear_modulus for _, law in layers]).sum()))

    def stresses(self, slope_angle, gravity=GRAVITY):
        """sigma and tau [Pa] that its weight puts on the weak layer; slope_angle [degrees], tau >= 0."""
        weight, angle = self.density * gravity * self.thickness, np.radians(abs(slope_angle))
        return weight * np.cos(angle), weight * np.sin(angle)

    @property
    def shear_speed(self):
        """c_s = sqrt(G / rho) [m/s]"""
        return float(np.sqrt(self.shear_modulus / self.density))

    @property
    def plate_speed(self):
        """Longitudinal wave of the plate, sqrt(E' / rho) [m/s]: the speed of a crack in shear above the friction angle
        (Bobillier et al. 2025, Trottet et al. 2022, doi:10.1038/s41567-022-01662-4, give 1.6 c_s, its value for a rod).
        """
        return float(np.sqrt(self.stretching_modulus / self.density))


def collapse_speed(slab, collapse_height, gravity=GRAVITY):
    """Speed of a collapse wave on the flat [m/s]: (g E' D^2 / (24 h rho))^(1/4), h the collapse height [m].

    Heierli (2005), doi:10.1029/2004JF000178 (solitary collapse wave in a plate).
    """
    return float((gravity * slab.bending_modulus * slab.thickness**2 / (24.0 * collapse_height * slab.density))**0.25)


def energy_of_cut(slab, sigma, tau, a):
    """Strain energy that a cut of length a sets free [J/m], slab on a rigid weak layer:

        U = 3 sigma^2 a^5 / (10 E' D^3) + sigma^2 a^3 / (5 G D) + tau^2 a^3 / (6 E' D)

    bending, shear (factor 5/6) and stretching of a cantilever: the leading terms of Heierli et al. (2008),
    doi:10.1126/science.1153948, derived anew.
    """
    D = slab.thickness
    bending = 0.3 * sigma**2 * a**5 / (slab.bending_modulus * D**3)
    shear = 0.2 * sigma**2 * a**3 / (slab.shear_modulus * D)
    return bending + shear + tau**2 * a**3 / (6.0 * slab.stretching_modulus * D)


def energy_release_rate(slab, sigma, tau, a):
    """dU/da [J/m2] of `energy_of_cut`."""
    D = slab.thickness
    bending = 1.5 * sigma**2 * a**4 / (slab.bending_modulus * D**3)
    shear = 0.6 * sigma**2 * a**2 / (slab.shear_modulus * D)
    return bending + shear + 0.5 * tau**2 * a**2 / (slab.stretching_modulus * D)


def critical_length_by_energy(slab, sigma, tau, fracture_energy):
    """a_c [m] at which dU/da of `energy_of_cut` is the fracture energy. A rigid weak layer: an upper bound."""
    reach = slab.thickness
    while energy_release_rate(slab, sigma, tau, reach) < fracture_energy:
        reach *= 2.0
    return _root(lambda a: energy_release_rate(slab, sigma, tau, a) - fracture_energy, reach)


def critical_length_by_strength(slab, sigma, tau, shear_strength, weak_layer_thickness, weak_layer_shear_modulus):
    """a_c = L / sigma (-tau + sqrt(tau^2 + 2 sigma (tau_p - tau))),  L = sqrt(E' D t / G_wl); NaN beyond the strength.

    Gaume et al. (2017), doi:10.5194/tc-11-217-2017.
    """
    if tau >= shear_strength:
        return np.nan
    reach = np.sqrt(slab.stretching_modulus * slab.thickness * weak_layer_thickness / weak_layer_shear_modulus)
    return float(reach / sigma * (np.sqrt(tau**2 + 2.0 * sigma * (shear_strength - tau)) - tau))


def shear_strength(law, sigma):
    """Largest shear stress [Pa] that a law bears beside the normal stress sigma, without strain along the layer."""
    state = np.array(law.initial_state())
    lateral = law.lateral_pressure * sigma

    def overload(tau):
        stress = -np.diag([lateral, lateral, sigma])
        stress[0, 2] = stress[2, 0] = tau
        return float(law.yield_function(stress, state))

    if not np.isfinite(overload(0.0)) or overload(0.0) >= 0.0:
        return np.nan if overload(0.0) < 0.0 else 0.0
    reach = max(sigma, 1.0)
    while overload(reach) < 0.0:
        reach *= 2.0
    return _root(overload, reach)


def maxwell_load(shortening, stress):
    """Load [Pa] below which no collapse runs on the flat, and the shortening [-] that it ends at: the equal-area line

        sigma_M e_f = int_0^e_f P de,   P(e_f) = sigma_M

    shortening (n,), stress (n,): nominal oedometric curve P(e) of the weak layer from 0 through collapse to where it
    bears its peak again. NaN where P does not fall below its peak, or does not come back. Ericksen (1975) for bars;
    here no load can drive the front below sigma_M, as it would give less work than the collapse takes.
    """
    e, P = np.asarray(shortening, float), np.asarray(stress, float)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (P[1:] + P[:-1]) * np.diff(e))])
    lowest = _valley(P)
    if lowest is None:
        return np.nan, np.nan
    surplus = P[lowest:] * e[lowest:] - work[lowest:]  # what the load at e gives over what the collapse takes
    rises = np.flatnonzero(surplus >= 0.0)
    if not len(rises):
        return np.nan, np.nan
    i = lowest + rises[0]
    if i == 0 or rises[0] == 0:
        return float(P[i]), float(e[i])
    share = -surplus[rises[0] - 1] / (surplus[rises[0]] - surplus[rises[0] - 1])
    return float(P[i - 1] + share * (P[i] - P[i - 1])), float(e[i - 1] + share * (e[i] - e[i - 1]))


def _valley(P):
    """Index of the lowest stress after the first peak; None without one."""
    peak = int(np.argmax(np.append(np.diff(P) < 0.0, True)))
    if peak >= len(P) - 2:
        return None
    return peak + int(np.argmin(P[peak:]))


def collapse_curve(law, largest=0.2, steps=4000):
    """Oedometric compression of a law: shortening e [-], nominal stress P [Pa], dissipation [J/m3], (steps,) each."""
    from snowmpm.materials import MaterialPoint

    e = np.linspace(0.0, largest, steps + 1)[1:]
    F = np.tile(np.eye(3), (steps, 1, 1))
    F[:, 2, 2] = 1.0 - e
    path = MaterialPoint(law).drive(F)
    return e, -path.kirchhoff[:, 2, 2] / (1.0 - e), path.dissipation, path.state


def fracture_energy(law, thickness):
    """Energy per area [J/m2] that the collapse of a weak layer takes until it has lost its strength: the work int P de
    over the oedometric curve to the end of softening, times the thickness; NaN for a law that does not soften."""
    e, P, _, state = collapse_curve(law)
    damage = np.asarray(law.outputs(state).get("damage", np.zeros(len(e))))
    broken = np.flatnonzero(damage >= 1.0 - 1e-9)
    if not len(broken):
        return np.nan
    last = broken[0]
    return float(thickness * (0.5 * (P[1 : last + 1] + P[:last]) @ np.diff(e[: last + 1])))


def _root(function, upper):
    """Where a function of one length changes sign between 0 and `upper` [m], to the last bit, by bisection.

    scipy's own would bring 49 MiB of it into every simulation of a saw test. Raises ValueError without a change.
    """
    lower, sign = 0.0, np.sign(function(0.0))
    if sign * np.sign(function(upper)) > 0.0:
        raise ValueError(f"no change of sign between 0 and {upper:g}")
    while lower < (middle := 0.5 * (lower + upper)) < upper:
        if sign * function(middle) > 0.0:
            lower = middle
        else:
            upper = middle
    return middle

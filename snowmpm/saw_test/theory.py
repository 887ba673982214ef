"""Theories of the propagation saw test. NumPy; lengths [m], stresses [Pa], energies per area [J/m2].

Slab: a plate in plane strain, E' = E / (1 - nu^2), of thickness D; sigma, tau: normal and shear stress from its weight
on the weak layer, sigma > 0 in compression, tau > 0 if the saw cuts upslope. Slabs of several layers enter by their
mean density and the moduli with the same stiffness in bending, stretching and shear.
"""

from dataclasses import dataclass

import numpy as np

GRAVITY = 9.81
SHARE_OF_SHEAR_SPEED = 0.6
"""Largest speed of a flat anticrack over that of shear waves in the slab: Bobillier et al. (2024), up to 0.6."""
FIRST_CUT, LONGER_CUT = 0.01, 1.05
"""Cuts that are examined for the first critical one [D], each a multiple of the one before."""


@dataclass(frozen=True)
class Slab:
    """thickness D [m], density [kg/m3], moduli [Pa]: bending 12 B / D^3 and stretching A / D, both in plane strain;
    shear 6 S / (5 D), S the stiffness in shear (`_shear_stiffness`)."""

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
        shear = _shear_stiffness(d, plate, np.array([law.shear_modulus for _, law in layers]), neutral, bending)
        return cls(float(total), float(d @ [law.density for _, law in layers] / total),
                   float(12.0 * bending / total**3), float(plate @ d / total), float(1.2 * shear / total))

    def stresses(self, slope_angle, gravity=GRAVITY):
        """sigma and tau [Pa] from its weight on the weak layer; slope_angle [degrees], > 0 upslope."""
        weight, angle = self.density * gravity * self.thickness, np.radians(slope_angle)
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


def _shear_stiffness(d, plate, shear, neutral, bending):
    """S [N/m] of a layered beam: a shear force Q stores the energy Q^2 / (2 S) per length, with the shear stress that
    follows from equilibrium in bending,

        1 / S = int s^2 / (G B^2) dz,    s(z) = int_0^z E' (z' - z_n) dz',   z_n the neutral axis

    It is 5 G D / 6 for one layer, and G_c e^2 / d_c for two thin stiff faces at a distance e on a soft core. d, plate
    (E'), shear (G): (n,), of the layers from below. WEAC takes 5/6 of the sum of G d, with equal shear strain in every
    layer. That is stiffer: by 5 % for a slab whose modulus grows fourfold downward, by far more if one layer is soft.
    """
    points, weights = np.polynomial.legendre.leggauss(3)  # exact: s is a parabola in each layer
    bottom, moment, compliance = 0.0, 0.0, 0.0
    for height, modulus, rigidity in zip(d, plate, shear, strict=True):
        def first_moment(z, start=bottom, before=moment, modulus=modulus):
            return before + 0.5 * modulus * ((z - neutral) ** 2 - (start - neutral) ** 2)

        at = bottom + 0.5 * height * (points + 1.0)
        compliance += 0.5 * height * (weights @ first_moment(at) ** 2) / rigidity
        bottom, moment = bottom + height, first_moment(bottom + height)
    return bending**2 / compliance


def collapse_speed(slab, collapse_height, gravity=GRAVITY):
    """Speed of a collapse wave on the flat [m/s]: (g E' D^2 / (24 h rho))^(1/4), h the collapse height [m].

    Heierli (2005), doi:10.1029/2004JF000178 (solitary collapse wave in a plate).
    """
    return float((gravity * slab.bending_modulus * slab.thickness**2 / (24.0 * collapse_height * slab.density))**0.25)


def energy_of_cut(slab, sigma, tau, a, ends="normal"):
    """Energy [J/m] released by a cut of length a, slab on a rigid weak layer:

        U = pi a^2 (sigma^2 + tau^2) / (2 E')                              as a crack in an infinite body
          + tau^2 a^3 / (6 E' D)                                           stretching
          + 3 eta / (2 E' D^2) m(a)^2                                      rotation of the slab at the tip
          + 6 / (E' D^3) int_0^a b(s)^2 ds + 3 / (5 G D) int_0^a q(s)^2 ds bending and shear of the overhang

    ends "normal":   m = (sigma a + tau D) a / 2,  q = sigma s + tau D / 2,  b = sigma s^2 / 2
    ends "vertical": m = sigma a^2 / 2,            q = sigma s,              b = (sigma s - tau D) s / 2
    eta^2 = 2 E' / (5 G).

    With ends normal to the slope this is Heierli, Gumbsch & Zaiser (2008), doi:10.1126/science.1153948, as van
    Herwijnen et al. (2016), doi:10.1017/jog.2016.90, write it,

        U = pi a^2 (sigma^2 + tau^2) / (2 E') + a^3 / (6 D E') (l_tt tau^2 + l_st sigma tau + l_ss sigma^2)
        l_tt = 1 + 9 eta D / (4 a) + 9 eta^2 D^2 / (4 a^2),   l_st = 9 eta / 2 + 9 eta^2 D / (2 a),
        l_ss = 3 eta^2 + 9 eta a / (4 D) + 9 a^2 / (5 D^2),   eta^2 = 4 (1 + nu) / 5

    whose eta has E' / G of plane stress; here it is that of plane strain, a difference of 3 % of U. The form for
    vertical ends is derived here in the same way: the centre of the overhang lies D tan(slope) / 2 further back, which
    reduces the moment of its weight. The sign of tau distinguishes upslope from downslope cuts. Compared with finite
    elements on a rigid layer, dU/da is within 20 % for cuts of 0.6 to 2 D on the flat and, with normal ends, upslope at
    35 degrees. Shorter cuts are no beams: there the first term is too large, the more so if tau acts against sigma.
    """
    return _of_cut(slab, sigma, tau, a, ends)[0]


def energy_release_rate(slab, sigma, tau, a, ends="normal"):
    """dU/da [J/m2] of `energy_of_cut`."""
    return _of_cut(slab, sigma, tau, a, ends)[1]


def _of_cut(slab, sigma, tau, a, ends):
    """U [J/m] and dU/da [J/m2]; the ends differ in the shares of tau D in m, q and b of `energy_of_cut`."""
    D, stretching, bending, shear = slab.thickness, slab.stretching_modulus, slab.bending_modulus, slab.shear_modulus
    at_tip, in_shear, in_bending = {"normal": (0.5, 0.5, 0.0), "vertical": (0.0, 0.0, -0.5)}[ends]
    eta = np.sqrt(0.4 * bending / shear)
    moment, slope = 0.5 * sigma * a**2 + at_tip * tau * D * a, sigma * a + at_tip * tau * D
    force, lean = in_shear * tau * D, in_bending * tau * D
    energy = (0.5 * np.pi * a**2 * (sigma**2 + tau**2) / stretching + tau**2 * a**3 / (6.0 * stretching * D)
              + 1.5 * eta * moment**2 / (bending * D**2)
              + 6.0 * (sigma**2 * a**5 / 20.0 + sigma * lean * a**4 / 4.0 + lean**2 * a**3 / 3.0) / (bending * D**3)
              + 0.6 * (sigma**2 * a**3 / 3.0 + sigma * force * a**2 + force**2 * a) / (shear * D))
    rate = (np.pi * a * (sigma**2 + tau**2) / stretching + 0.5 * tau**2 * a**2 / (stretching * D)
            + 3.0 * eta * moment * slope / (bending * D**2)
            + 6.0 * (0.5 * sigma * a**2 + lean * a) ** 2 / (bending * D**3)
            + 0.6 * (sigma * a + force) ** 2 / (shear * D))
    return energy, rate


def critical_length_by_energy(slab, sigma, tau, fracture_energy, ends="normal"):
    """Least a_c [m] at which dU/da of `energy_of_cut` reaches the fracture energy; 0 if it is larger from the start.

    For a rigid weak layer. On a compliant layer the slab rotates more, and the crack runs earlier.
    """
    reach = FIRST_CUT * slab.thickness
    while energy_release_rate(slab, sigma, tau, reach, ends) < fracture_energy:
        reach *= LONGER_CUT

    def surplus(a):
        return energy_release_rate(slab, sigma, tau, a, ends) - fracture_energy

    return 0.0 if surplus(0.0) >= 0.0 else _root(surplus, reach)


def critical_length_by_strength(slab, sigma, tau, shear_strength, weak_layer_thickness, weak_layer_shear_modulus):
    """a_c = L / sigma (-tau + sqrt(tau^2 + 2 sigma (tau_p - tau))),  L = sqrt(E' D t / G_wl); NaN if tau exceeds the
    strength.

    Gaume et al. (2017), doi:10.5194/tc-11-217-2017.
    """
    if tau >= shear_strength:
        return np.nan
    reach = np.sqrt(slab.stretching_modulus * slab.thickness * weak_layer_thickness / weak_layer_shear_modulus)
    return float(reach / sigma * (np.sqrt(tau**2 + 2.0 * sigma * (shear_strength - tau)) - tau))


def shear_strength(law, sigma, at_end=False):
    """Largest shear stress [Pa] that a law bears under the normal stress sigma, without strain along the layer;
    at_end: at a free end, without support along the layer."""
    state = np.array(law.initial_state())
    along = across = law.lateral_pressure * sigma
    if at_end:
        along, across = 0.0, across / (1.0 + law.lateral_pressure)  # nu sigma, by plane strain

    def overload(tau):
        stress = -np.diag([along, across, sigma])
        stress[0, 2] = stress[2, 0] = tau
        return float(law.yield_function(stress, state))

    if not np.isfinite(overload(0.0)) or overload(0.0) >= 0.0:
        return np.nan if overload(0.0) < 0.0 else 0.0
    reach = max(sigma, 1.0)
    while overload(reach) < 0.0:
        reach *= 2.0
    return _root(overload, reach)


def maxwell_load(shortening, stress):
    """Maxwell's load [Pa], below which no collapse propagates on the flat, and the shortening [-] after it: equal-area
    line

        sigma_M e_f = int_0^e_f P de,   P(e_f) = sigma_M

    shortening (n,), stress (n,): nominal oedometric curve P(e) of the weak layer from 0 through collapse until P
    reaches its peak again. NaN if P does not fall below its peak, or does not reach it again. Ericksen (1975) for bars.
    Below sigma_M no load can drive the front, since its work is less than the collapse takes.
    """
    e, P = np.asarray(shortening, float), np.asarray(stress, float)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (P[1:] + P[:-1]) * np.diff(e))])
    lowest = _valley(P)
    if lowest is None:
        return np.nan, np.nan
    surplus = P[lowest:] * e[lowest:] - work[lowest:]  # work of the load at e minus work of the collapse
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
    """Energy per area [J/m2] of the collapse of a weak layer until it has lost its strength: the work int P de over the
    oedometric curve to the end of softening, times the thickness; NaN for a law that does not soften."""
    e, P, _, state = collapse_curve(law)
    damage = np.asarray(law.outputs(state).get("damage", np.zeros(len(e))))
    broken = np.flatnonzero(damage >= 1.0 - 1e-9)
    if not len(broken):
        return np.nan
    last = broken[0]
    return float(thickness * (0.5 * (P[1 : last + 1] + P[:last]) @ np.diff(e[: last + 1])))


def _root(function, upper):
    """Where a function of one length changes sign between 0 and `upper` [m], to the last bit, by bisection.

    SciPy's routine would load 49 MiB into every simulation of a saw test. Raises ValueError without a change.
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

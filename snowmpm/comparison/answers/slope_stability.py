"""The factor of safety of a slope of soil: Bishop's slices on circles, the least over many circles.

    F = sum (c b + W tan phi) / m / sum W sin a,   m = cos a + sin a tan phi / F

with b width, W weight and a inclination of the base of each slice; Bishop (1955), doi:10.1680/geot.1955.5.1.7. Strength
is that of the law in plane strain: of a Drucker-Prager cone (the failure surface of the hypoplastic law, too) of slope
alpha, sin phi = alpha/sqrt(3) for flow without dilation, and c = apex tan phi.

Slip without dilation goes on at a lower shear stress, tan phi' = sin phi cos psi / (1 - sin phi sin psi), c' likewise
(Davis 1968): a slope of a non-associated law fails at a factor between that of its full and of its reduced strength.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from snowmpm.comparison.answers.answer import Answer
from snowmpm.errors import InputError

SLICES = 60


@dataclass(frozen=True)
class Circle:
    """A slip circle and its factor of safety; x, z of the centre and radius [m]."""

    x: float
    z: float
    radius: float
    factor: float


@dataclass(frozen=True)
class Slope:
    """Upper surface of a slope, x (n,) growing and z (n,) [m]; base: below it nothing slips [m]; weight: unit weight
    [N/m3]; cohesion [Pa]; tan_phi [-]."""

    x: np.ndarray
    z: np.ndarray
    base: float
    weight: float
    cohesion: float
    tan_phi: float

    def factor(self, x, z, radius):
        """Factor of safety of a circle; inf where it cuts no slope, or passes below the base."""
        ends = self._ends(x, z, radius)
        if ends is None or z - radius < self.base:
            return np.inf
        edges = np.linspace(*ends, SLICES + 1)
        middle, b = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
        sine = (middle - x) / radius
        bottom = z - radius * np.sqrt(1.0 - sine**2)
        height = np.interp(middle, self.x, self.z) - bottom
        if (height < -1e-9).any():
            return np.inf
        weight, cosine = self.weight * b * height, np.sqrt(1.0 - sine**2)
        driving = abs(float(weight @ sine))
        if driving < 1e-6 * float(weight.sum()):
            return np.inf
        # The base rises towards the side from which the mass slides, whichever that is
        uphill = sine * np.sign(float(weight @ sine))
        factor = 1.0
        for _ in range(100):
            m = cosine + uphill * self.tan_phi / factor
            if (m <= 0.05).any():
                return np.inf
            new = float(((self.cohesion * b + weight * self.tan_phi) / m).sum()) / driving
            if abs(new - factor) < 1e-6 * new:
                return new
            factor = new
        return np.inf

    def _ends(self, x, z, radius):
        """x where the circle, below its middle, meets the surface: first and last, or None."""
        at = np.linspace(max(self.x[0], x - radius), min(self.x[-1], x + radius), 400)
        inside = np.interp(at, self.x, self.z) > z - np.sqrt(np.clip(radius**2 - (at - x) ** 2, 0.0, None))
        inside &= np.abs(at - x) < radius
        if inside.sum() < 5 or inside[0] or inside[-1]:
            return None
        first, last = np.flatnonzero(inside)[[0, -1]]
        return at[first - 1], at[last + 1]

    def critical(self):
        """The `Circle` of the least factor: all that leave at given places with a given depth, then refined."""
        from scipy.optimize import minimize

        best = Circle(0.0, 0.0, 0.0, np.inf)
        size, low = np.ptp(self.z), self.z.min()
        rises = np.flatnonzero(np.abs(np.diff(self.z)) > 1e-9)
        begin, end = self.x[rises[0]], self.x[rises[-1] + 1]
        for x in np.linspace(begin - 0.5 * size, end + 0.5 * size, 21):
            for z in low + size * np.linspace(0.9, 3.0, 15):
                for radius in np.linspace(z - low - 0.9 * (low - self.base), z - low + 0.999 * (low - self.base), 12):
                    if radius > 0.0:
                        factor = self.factor(x, z, radius)
                        best = Circle(x, z, radius, factor) if factor < best.factor else best
        if not np.isfinite(best.factor):
            return best
        found = minimize(lambda at: min(self.factor(*at), 1e3), [best.x, best.z, best.radius], method="Nelder-Mead",
                         options={"xatol": 1e-3 * size, "fatol": 1e-5, "maxiter": 400})
        return Circle(*map(float, found.x), float(found.fun)) if found.fun < best.factor else best


def plane_strain_strength(material):
    """Coulomb's cohesion [Pa] and friction angle [rad] in plane strain, and the dilation angle [rad], of a law's table.
    ValueError for a law without."""
    kind = material["kind"]
    angle, cohesion = np.radians(material.get("friction_angle", 0.0)), material.get("cohesion", 0.0)
    dilation = np.radians(material.get("dilation_angle", 0.0))
    if kind == "mohr_coulomb":
        return cohesion, angle, dilation
    if kind not in ("drucker_prager", "hypoplastic"):
        raise ValueError(f"no strength in plane strain of {kind} is known here")
    from snowmpm.materials.cone import cone_friction_angle, cone_slope

    degrees = np.degrees(dilation)
    slope = cone_slope(np.degrees(angle), material.get("cone", "triaxial_compression"), degrees)
    plane = np.radians(cone_friction_angle(slope, "plane_strain", degrees))
    return cohesion / np.tan(angle) * np.tan(plane), plane, dilation


class SlopeStability(Answer):
    """The first body, a polygon, as it is at the start, on the lowest of its points."""

    SOURCE = "Bishop (1955), doi:10.1680/geot.1955.5.1.7, the least of many circles"

    def __init__(self, case, reference):
        super().__init__(case, reference)
        shape = case.body["shape"]
        if shape["kind"] != "polygon":
            raise InputError(f"{case.run.path}: bodies.0.shape.kind = {shape['kind']!r}: what is known of this scene is"
                             " that of a polygon")
        self._points = np.array(shape["points"], float)
        try:
            self._strength = plane_strain_strength(case.material)
        except ValueError as error:
            raise InputError(f"{case.run.path}: {error}") from None

    def slope(self, reduced=False):
        """The `Slope`; reduced: with the strength of slip that dilates as the law says."""
        cohesion, angle, dilation = self._strength
        tan_phi = np.tan(angle)
        if reduced:
            share = np.cos(dilation) * np.cos(angle) / (1.0 - np.sin(dilation) * np.sin(angle))
            cohesion, tan_phi = share * cohesion, share * tan_phi
        x, z = upper_surface(self._points)
        weight = self.case.material["density"] * -self.case.gravity[-1]
        return Slope(x, z, float(self._points[:, 1].min()), weight, cohesion, tan_phi)

    @cached_property
    def circle(self):
        return self.slope().critical()

    def facts(self):
        reduced = self.slope(reduced=True).critical().factor
        return {"factor of safety": f"{self.circle.factor:.3f}; {reduced:.3f} where slip goes on without dilation"}

    def profile(self):
        circle, (x, z) = self.circle, upper_surface(self._points)
        s = np.linspace(circle.x - circle.radius, circle.x + circle.radius, 400)
        low = circle.z - np.sqrt(np.clip(circle.radius**2 - (s - circle.x) ** 2, 0.0, None))
        inside = (low < np.interp(s, x, z)) & (s > x[0]) & (s < x[-1])
        return f"slip circle, factor {circle.factor:.2f}", s[inside], low[inside]


def upper_surface(points):
    """Upper line of a polygon (n, 2): x growing, z."""
    first, last = int(np.lexsort((-points[:, 1], points[:, 0]))[0]), int(np.lexsort((points[:, 1], points[:, 0]))[-1])
    ways = [np.array([points[i % len(points)] for i in range(first, last + 1 if last >= first
                                                             else last + len(points) + 1)]),
            np.array([points[i % len(points)] for i in range(last, first + 1 if first >= last
                                                             else first + len(points) + 1)])[::-1]]
    way = max(ways, key=lambda way: way[:, 1].mean())
    return way[:, 0], way[:, 1]

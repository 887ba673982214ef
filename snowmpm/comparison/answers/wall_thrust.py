"""The thrust of grains at rest on a wall, bounded by the balance of wedges.

Behind the wall, cut off by a plane through its foot that rises by omega from the bed, lies a wedge of weight W. Its
balance leaves the force N on the wall between two values, since no plane carries a shear stress beyond friction:

    held up by all friction     N >= N_min(omega)        pressed against all friction     N <= N_max(omega)

so the largest N_min and the smallest N_max over all omega hold N between them (Coulomb's wedges of active and passive
thrust). They bound every state of rest, whatever its history; the rougher the wall, the wider they are.

The friction angle is the largest that the law allows in plane strain: on a Drucker-Prager cone of slope alpha it is
that of the associated limit state, sin phi = 3 alpha/sqrt(3 (12 - alpha^2)) (for tan phi alpha = 3 sqrt(3) tan phi /
sqrt(9 + 12 tan^2 phi)), a little above the angle that non-associated flow reaches.
"""

import numpy as np

from snowmpm.comparison.answers.answer import Answer, History
from snowmpm.comparison.answers.column import cone_facts
from snowmpm.comparison.profile import profile
from snowmpm.comparison.quantity import Quantity
from snowmpm.errors import InputError

REST = 0.1
"""Share of the run, its end, over which the thrust is a mean."""

ANGLES = np.radians(np.arange(0.0, 88.0, 0.5))


def wedge_bounds(s, depth, density, gravity, friction, bed_friction, wall_friction):
    """Least and largest thrust [N/m] normal to a wall at s = 0.

    s (n,), growing from 0 at the wall [m], depth (n,): of the grains above the bed [m]; density [kg/m3]; gravity
    (along the bed towards the wall, into the bed) [m/s2]; frictions: angles inside, on bed and wall [rad].
    """
    least, largest = 0.0, np.inf
    for omega in ANGLES:
        above = np.clip(depth - s * np.tan(omega), 0.0, None)
        gone = np.flatnonzero(above <= 0.0)
        gone = gone[gone > 0]
        if len(gone):
            above[gone[0] :] = 0.0
        area = float(np.sum(0.5 * (above[1:] + above[:-1]) * np.diff(s)))
        weight = density * area * np.asarray(gravity, float)
        own = bed_friction if omega == 0.0 else friction
        least = max(least, _thrust(weight, omega, -own, -wall_friction))
        largest = min(largest, _thrust(weight, omega, own, wall_friction))
    return least, max(largest, least)


def _thrust(weight, omega, plane, wall):
    """N of the balance of a wedge: weight (towards the wall, down) + N (-1, -tan wall) + R = 0, R inclined by the angle
    `plane` from the normal of its plane; positive angles resist a wedge that is pushed away from the wall."""
    # Towards the wall is +1 along the bed, up is +1 across; the plane rises away from the wall, its normal leans to it
    lean = omega + plane
    normal = np.array([np.sin(lean), np.cos(lean)])
    if normal[1] <= 1e-9:
        return np.inf if plane > 0.0 else 0.0
    force = np.array([[-1.0, normal[0]], [-np.tan(wall), normal[1]]])
    thrust, reaction = np.linalg.solve(force, np.array([-weight[0], weight[1]]))
    if reaction < 0.0 or thrust < 0.0:
        return np.inf if plane > 0.0 else 0.0
    return float(thrust)


def largest_friction(material):
    """The largest friction angle [rad] that a law allows in plane strain."""
    kind = material["kind"]
    if kind == "mohr_coulomb":
        return np.radians(material["friction_angle"])
    if kind == "drucker_prager":
        from snowmpm.materials.cone import cone_slope

        alpha = cone_slope(material["friction_angle"], material["cone"], material["dilation_angle"])
        return np.arctan(3.0 * alpha / np.sqrt(27.0 - 12.0 * alpha**2))
    raise ValueError(f"no friction angle of {kind} is known here; there is one of drucker_prager and mohr_coulomb")


class WallThrust(Answer):
    """The first body's material against the reference's wall, lying on its bed; scene axes along and across the bed."""

    SOURCE = "Coulomb's wedges over the deposit of the run; balance of momentum over wall and bed"

    def __init__(self, case, reference):
        super().__init__(case, reference)
        self._wall, self._bed = (case.run.obstacles[reference[name]] for name in ("wall", "bed"))
        try:
            self._friction = largest_friction(case.material)
        except ValueError as error:
            raise InputError(f"{case.run.path}: {error}") from None

    def thrust(self):
        """Mean normal force on the wall over the end of the run [N/m]."""
        time, impulse = self._wall.time, self._wall.impulse[:, 0]
        begin = time[-1] * (1.0 - REST)
        return float((impulse[-1] - np.interp(begin, time, impulse)) / (time[-1] - begin))

    def bounds(self):
        """Least and largest thrust [N/m]."""
        run, case = self.case.run, self.case
        face = float(self._wall.vertices[:, 0].min() + run.origin[0])
        level = float(self._bed.vertices[:, 2].max() + run.origin[2])
        found = profile(case, run.frame(-1))
        behind = found.s < face
        s, depth = face - found.s[behind][::-1], found.top[behind][::-1] - level
        s, depth = np.concatenate([[0.0], s]), np.concatenate([depth[:1], depth])
        angles = [self._surface_friction(name) for name in ("bed", "wall")]
        return wedge_bounds(s, depth, case.material["density"], (case.gravity[0], -case.gravity[1]), self._friction,
                            *angles)

    def _surface_friction(self, which):
        """Friction angle on an obstacle, at most that inside [rad]."""
        name = self.reference[which]
        spec = next(one for one in self.case.scene["obstacles"] if one["name"] == name)
        return self._friction if spec["contact"] == "stick" else min(self._friction, np.arctan(spec["friction"]))

    def momentum_gap(self):
        """Impulse on the wall less what the momentum of the run says it must be, over it [-]."""
        run, case = self.case.run, self.case
        mass, time = run.history["mass"], run.history["time"]
        gained = run.history["momentum_x"][-1] - run.history["momentum_x"][0]
        from scipy.integrate import trapezoid  # slow to import

        weight = case.gravity[0] * trapezoid(mass, time)
        on_wall, on_bed = self._wall.impulse[-1, 0], self._bed.impulse[-1, 0]
        return float((on_wall - (weight - gained - on_bed)) / on_wall)

    def quantities(self):
        return [Quantity("thrust at rest", "N/m", self.thrust(), *self.bounds()),
                Quantity("gap of the momentum balance", "1", self.momentum_gap(), -0.03, 0.03)]

    def facts(self):
        peak = self.history()
        return {"largest force on the wall": f"{peak.y.max():.4g} N/m, mean over {peak.x[1] - peak.x[0]:.3g} s",
                **cone_facts(self.case.material)}

    def history(self):
        """Force on the wall, means between frames, and the bounds at rest."""
        times = self.case.run.times
        impulse = np.interp(times, np.concatenate([[0.0], self._wall.time]),
                            np.concatenate([[0.0], self._wall.impulse[:, 0]]))
        low, high = self.bounds()
        middle = 0.5 * (times[1:] + times[:-1])
        end = times[-1] * np.array([1.0 - REST, 1.0, 1.0, 1.0 - REST, 1.0 - REST])
        return History("time  [s]", "force on the wall  [N/m]", middle, np.diff(impulse) / np.diff(times), end,
                       np.array([low, low, high, high, low]))

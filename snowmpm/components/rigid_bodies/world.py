"""All free bodies of a scene, what they rest on, and a step of them.

A step of the snow, whose contact took their velocities v and places x at its begin, gives them impulses J. Then

    v* = v + J / M + dt g
    v' = v* + contact                         `impulses`, at x
    x' = x + dt v',  likewise the rotation    `.motion`
"""

import numpy as np

from snowmpm.components.rigid_bodies.contact import SINK, resolve
from snowmpm.components.rigid_bodies.contact_points import ContactPoints


class World:
    """Free bodies, the ground and sides under them, and obstacles that are not free."""

    def __init__(self, bodies, obstacles=(), ground=None, sides=(), box=None):
        """bodies: `Body`s; obstacles: `solids.Obstacle`s that are not free; ground: query(points) -> distance, normal,
        or None; sides: (axis, sign, level [m]) of sides of the domain that hold bodies; box: lower and upper corner
        (dim,) [m] of the domain, outside which a body is let go."""
        self.bodies, self.box = list(bodies), box
        self._still = [*([ground] if ground else []), *(_side(*side) for side in sides)]
        self._obstacles = list(obstacles)
        self._clear = {}
        self._last, self._warm, self.unsettled = None, {}, 0

    def begin(self):
        """Time zero."""
        for body in self.bodies:
            body.begin()
        self._last, self._warm, self._clear, self.unsettled = None, {}, {}, 0

    def overlaps(self):
        """(body, words, depth [m]) of all that overlaps."""
        for body in self.bodies:
            others = [("the ground or a side of the domain", query) for query in self._still]
            others += [(f"obstacle {obstacle.name}", lambda x, o=obstacle: o.query_at(x, 0.0))
                       for obstacle in self._obstacles]
            others += [(f"obstacle {other.name}", other.query) for other in self.bodies if other is not body]
            for words, query in others:
                points, radius = body.probes
                yield body, words, float((radius - query(points)[0]).max())

    # ---- the step ---------------------------------------------------------------------------------------------

    def advance(self, time, dt, gravity, totals):
        """A step of dt [s] from `time` [s] under gravity (dim,) [m/s2]; totals (obstacles, ...) of what the snow gave
        all obstacles so far (`stepping.contract.PushesObstacles.obstacle_totals`)."""
        last = np.zeros_like(totals) if self._last is None else self._last
        gains, self._last = (totals - last)[:, :-1], np.array(totals)
        acting = [body for body in self.bodies if not body.gone and time + dt >= body.motion.start]
        for body in acting:
            body.advance(gains[body.number], gravity, dt)
        touches = self._touches(acting, time, dt, gravity)
        warm, self._warm = self._warm, {}
        if touches:
            self._warm, settled = resolve(acting, touches, dt, float(np.linalg.norm(gravity)), warm)
            self.unsettled += not settled
        for body in acting:
            body.motion.drift(dt)
            self._let_go(body)

    def _let_go(self, body):
        """A body that has left the domain sideways or downwards stays where it is, out of reach."""
        if self.box is None:
            return
        lower, upper = self.box
        beyond = body.motion.centre + body.radius < lower
        beyond[:-1] |= (body.motion.centre - body.radius > upper)[:-1]
        if beyond.any():
            body.gone = True
            body.impulse -= body.motion.mass_properties.mass * body.motion.velocity
            body.motion.stop()

    # ---- contact ----------------------------------------------------------------------------------------------

    def _touches(self, acting, time, dt, gravity):
        """`ContactPoints` of all bodies that may meet something in this step."""
        found, g = [], float(np.linalg.norm(gravity))
        margins = {body.number: 2.0 * dt * (body.speed + g * dt) + SINK * body.radius for body in acting}
        for body in acting:
            for s, query in enumerate(self._still):
                found += self._against_still(body, s, query, margins[body.number], dt)
            for o, obstacle in enumerate(self._obstacles):
                margin = margins[body.number] + 2.0 * dt * obstacle.speed_at(time)
                found += self._against_obstacle(body, len(self._still) + o, obstacle, margin, time)
        return found + self._between(acting, margins)

    def _between(self, acting, margins):
        """`ContactPoints` of bodies with each other: of pairs whose boxes meet."""
        bodies = [body for body in self.bodies if not body.gone]
        if len(bodies) < 2:
            return []
        low, high = (np.array(corners) for corners in zip(*(body.bounds for body in bodies), strict=True))
        margin = np.array([margins.get(body.number, -np.inf) for body in bodies])
        reach = np.maximum(margin[:, None], margin)[..., None]  # of two that are held: none
        meet = ((low[:, None] <= high + reach) & (low <= high[:, None] + reach)).all(axis=-1)
        return [touch for i, j in np.argwhere(np.triu(meet, 1)).tolist()
                for touch in self._against_body(bodies[i], bodies[j], float(reach[i, j, 0]))]

    def _against_still(self, body, s, query, margin, dt):
        clear = self._clear.get((body.number, s), 0.0) - dt * body.speed
        if clear > margin:
            self._clear[body.number, s] = clear
            return []
        touch, self._clear[body.number, s] = ContactPoints.of(body, None, s, query, margin)
        return touch

    def _against_obstacle(self, body, s, obstacle, margin, time):
        middle, _ = obstacle.frame(obstacle.motion.pose(time))
        if np.linalg.norm(body.motion.centre - middle) > body.radius + np.linalg.norm(obstacle.shape.size) + margin:
            return []
        return ContactPoints.of(body, None, s, lambda x: obstacle.query_at(x, time), margin,
                        lambda x: obstacle.velocity_at(x, time))[0]

    def _against_body(self, one, other, margin):
        found = []
        for first, second in ((one, other), (other, one)):
            if second.probe_radius > 0.0 and first.probe_radius == 0.0:
                continue  # the only point of a ball tells all
            found += ContactPoints.of(first, second, -1 - second.number, second.query, margin)[0]
            if first.probe_radius > 0.0:
                break
        return found

    # ---- reading ----------------------------------------------------------------------------------------------

    def row(self, gravity):
        """Numbers of the history: place, velocity and angular velocity of each body by "NAME_x" and so on, energy
        [J], what is left open of their momentum balance [-], and steps whose contact impulses did not settle."""
        found: dict[str, float] = {}
        left, size, energy = 0.0, 0.0, 0.0
        for body in self.bodies:
            motion = body.motion
            values = [*motion.centre, *motion.velocity, *motion.omega]
            found.update(zip(_names(body), map(float, values), strict=True))
            open_, terms = body.residual
            left, size = left + float(np.linalg.norm(open_)), size + float(terms)
            fallen = float(gravity @ (motion.centre - motion.start_centre))
            energy += motion.energy - motion.mass_properties.mass * fallen
        return {**found, "rigid_energy": energy, "rigid_momentum_residual": left / size if size > 0.0 else 0.0,
                "rigid_unsettled": float(self.unsettled)}

    def units(self):
        """Unit of each number of `row` that carries the name of a body."""
        found: dict[str, str] = {}
        for body in self.bodies:
            dim, turns = len(body.motion.centre), len(body.motion.spin)
            found.update(zip(_names(body), ["m"] * dim + ["m/s"] * dim + ["rad/s"] * turns, strict=True))
        return found

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name."""
        keys = list(self._warm)
        dim = len(self.bodies[0].motion.centre)
        return {"bodies": [body.state() for body in self.bodies], "unsettled": self.unsettled,
                "last": np.zeros((0, 0)) if self._last is None else self._last.copy(),
                "warm_keys": np.array(keys, np.int64).reshape(-1, 3),
                "warm": np.array([self._warm[key] for key in keys], float).reshape(-1, dim)}

    def restore(self, state):
        """Take over what `state()` gave."""
        for body, own in zip(self.bodies, state["bodies"], strict=True):
            body.restore(own)
        self._last = None if state["last"].size == 0 else np.array(state["last"], float)
        self._warm = {tuple(map(int, key)): np.array(p, float)
                      for key, p in zip(state["warm_keys"], state["warm"], strict=True)}
        self._clear, self.unsettled = {}, int(state["unsettled"])


def _side(axis, sign, level):
    def query(points):
        normal = np.zeros_like(points)
        normal[:, axis] = sign
        return sign * (points[:, axis] - level), normal

    return query


def _names(body):
    dim = len(body.motion.centre)
    axes = "xz" if dim == 2 else "xyz"
    turns = ["turning"] if dim == 2 else [f"turning_{axis}" for axis in axes]
    return [f"{body.name}_{part}" for part in (*axes, *(f"velocity_{axis}" for axis in axes), *turns)]

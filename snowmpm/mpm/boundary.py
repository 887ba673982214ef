"""All surfaces that bound the snow of one grid, and what they took from it."""

import numpy as np


class Boundary:
    """Terrain, sides and obstacles, in the order in which they act on nodes."""

    def __init__(self, frame, sides, obstacles, ground=None):
        """frame: `GridFrame`; sides: (dim, 2) names of `contact.CODES`, "open" or "periodic"; obstacles:
        `solids.Obstacle`s; ground: what `GridFrame.terrain` takes, or None."""
        self._frame = frame
        self.obstacles = [frame.solid(obstacle) for obstacle in obstacles]
        terrain = [frame.terrain(*ground)] if ground else []
        self.basal = terrain[0].basal if terrain else None
        self.surfaces = [*terrain, *frame.sides(sides), *self.obstacles]

    def bind(self, *scheme):
        """Kernels of all surfaces, see `Surface.bind`."""
        for surface in self.surfaces:
            surface.bind(*scheme)

    def move_to(self, time):
        """Bring obstacles to where they are at `time` [s]; -> whether one left the nodes found for it."""
        return any([surface.move_to(time, self._frame.origin, self._frame.dx)
                    for surface in self.obstacles if surface.moving])

    def speed_at(self, time):
        """Of the fastest obstacle [m/s]."""
        return max((surface.speed_at(time) for surface in self.obstacles), default=0.0)

    @property
    def work(self):
        """Energy that all surfaces took [J]."""
        dim = self._frame.dim
        return sum(surface.total[dim] for surface in self.surfaces)

    @property
    def given_to_obstacles(self):
        """`stepping.contract.PushesObstacles.obstacle_totals`."""
        dim = self._frame.dim
        rows = [surface.given_to_solid(self._frame.dx) for surface in self.obstacles]
        return np.array(rows).reshape(len(rows), dim + (1 if dim == 2 else 3) + 1)

    def restart(self):
        """Totals start again."""
        for surface in self.surfaces:
            surface.total[:] = 0.0

    def state(self):
        """Totals, one row a surface; friction of the ground, where it is computed under the snow."""
        return {"totals": np.array([surface.total for surface in self.surfaces]),
                "friction": self.basal.state() if self.basal else {}}

    def restore(self, state, particles):
        """Take over a `state()`, that of the particles as they are now."""
        for surface, total in zip(self.surfaces, state["totals"], strict=True):
            surface.total[:] = total
        if self.basal:
            self.basal.restore(state["friction"], particles)

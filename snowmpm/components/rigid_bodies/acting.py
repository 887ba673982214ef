"""All bodies of a scene in the steps of a method whose contact tells what the snow gives obstacles."""

from snowmpm.components.rigid_bodies.from_scene import rigid_world
from snowmpm.stepping.component import Adapter


def adapter(model):
    """`RigidBodies` of a `Model`."""
    return RigidBodies(rigid_world(model))


class RigidBodies(Adapter):
    """The bodies of a `World` among the obstacles of a solver. While the snow settles, they are held."""

    name = "rigid_bodies"

    def __init__(self, world):
        self.world = world

    def begin(self, solver):
        """Time zero."""
        self._solver = solver
        self.world.begin()

    def end_step(self, dt):
        """Give them what the snow gave in the step, and move them."""
        solver = self._solver
        if solver.damping_factor == 1.0:
            self.world.advance(solver.time, dt, solver.gravity, solver.obstacle_totals)

    def restart(self):
        """Time zero is now."""
        self.world.begin()

    def work(self):
        """Bodies."""
        return {"body": len(self.world.bodies)}

    def row(self):
        """`World.row`."""
        return self.world.row(self._solver.gravity)

    def units(self):
        """`World.units`."""
        return self.world.units()

    def state(self):
        """`World.state`."""
        return self.world.state()

    def restore(self, state):
        """Take over what `state()` gave."""
        self.world.restore(state)

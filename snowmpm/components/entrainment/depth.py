"""The snow cover in a depth-averaged flow."""

from snowmpm.components.entrainment.cover import Cover
from snowmpm.ground.friction import GroundFriction
from snowmpm.stepping.component import Adapter


def adapter(model):
    """`SnowCover` of the scene of a `Model`."""
    scene = model.scene
    return SnowCover(GroundFriction(scene.terrain.entrainment, scene.base_dir, model.surface.system, scene.source))


class SnowCover(Adapter):
    """What a `DepthSolver` takes up. law: of `.laws`, or `ground.friction.GroundFriction` of one."""

    name = "entrainment"
    moves_ground = True

    def __init__(self, law):
        self._law = law

    def intake(self, solver):
        """`Cover` of the solver's ground."""
        self.cover = Cover(solver.grid, solver.bed, *solver.on_ground(self._law))
        return self.cover

    def state(self):
        """What is left of the cover."""
        return self.cover.state()

    def restore(self, state):
        """Take over what `state()` gave."""
        self.cover.restore(state)

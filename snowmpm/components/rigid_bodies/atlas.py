"""Entry: bodies on each other, of unlike mass."""

import itertools

import numpy as np

from snowmpm.components.rigid_bodies.body import Body
from snowmpm.components.rigid_bodies.motion import FreeMotion
from snowmpm.components.rigid_bodies.world import World
from snowmpm.materials import Elastic
from snowmpm.scenes.schema import Scene
from snowmpm.solids import Obstacle
from snowmpm.study.atlas.entry import Entry

SNOW = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)


def stack(blocks, ratio, dim=2):
    """`World` of a stack of blocks of 1 m, the uppermost of which has `ratio` times the mass of the others."""
    made, box = [], {"kind": "box", "min": [4.0] * (dim - 1) + [0.0], "max": [5.0] * (dim - 1) + [1.0]}
    for i in range(blocks):
        place = {"kind": "box", "min": [0.0] * (dim - 1) + [float(i)], "max": [1.0] * (dim - 1) + [i + 1.0]}
        spec = Scene.model_validate({
            "name": "stack", "dimension": dim, "end_time": 1.0, "solver": {"dx": 0.5}, "materials": {"snow": SNOW},
            "domain": {"min": [-9.0] * (dim - 1) + [0.0], "max": [9.0] * dim},
            "bodies": [{"name": "snow", "material": "snow", "shape": box}],
            "obstacles": [{"name": "block", "shape": place,
                           "free": {"density": ratio * 1e3 if i == blocks - 1 else 1e3}}]}).obstacles[0]
        block = Obstacle.of(spec, dim, moved=lambda shape, spec=spec: FreeMotion.of_shape(spec.free, shape))
        made.append(Body(i, block, 0.5))
    world = World(made, ground=lambda x: (x[:, -1], np.tile(np.eye(dim)[-1], (len(x), 1))))
    world.begin()
    return world


def stacked(ratio, blocks):
    """Largest overlap, over the height of a block, in a `stack` of so many after 0.2 s."""
    world = stack(blocks, ratio)
    for k in range(40):
        world.advance(0.005 * k, 0.005, np.array([0.0, -9.81]), np.zeros((blocks, 4)))
    levels = [0.0, *(body.motion.centre[1] + 0.5 for body in world.bodies)]
    return max(low - high + 1.0 for low, high in itertools.pairwise(levels))


ENTRIES = (
    Entry(
        name="heavy_on_light", title="Heavy bodies on light ones",
        scene="A stack of blocks, the uppermost heavier than the others",
        seen="Impulses pass down a stack by a sweep for each block, and slowly where a heavy one lies on light ones:"
             " sweeps that are cut off leave blocks sunk into each other",
        cure="bodies of more equal mass, or fewer on each other", parameter="mass of the uppermost over the others",
        unit="", values=(1.0, 10.0, 100.0, 1e3, 1e4, 1e5),
        settings={"2 blocks": {"blocks": 2}, "6 blocks": {"blocks": 6}},
        # Between 40 000 and 60 000 the sweeps of six blocks settle or not by round-off
        symptom="overlap over height", limit=1e-3, measure=stacked, shown="6 blocks", resolution=0.2),
)

ATLAS = {"bodies and structures": ENTRIES}

"""Panels on an obstacle: their table, and what they do not go with.

    [[obstacles]]
    name = "wall"
    shape = { kind = "box", min = [20.0, -4.0, 0.0], max = [21.0, 4.0, 5.0] }
    panels = { size = 0.5, direction = [1.0, 0.0, 0.0] }
"""

import math
from typing import ClassVar

from snowmpm import components
from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.space import Direction
from snowmpm.scenes.spec import Positive, Spec

SHARE = 0.1
"""Of the time between two frames, which a pressure is a mean over where the scene does not say."""


class Panels(Spec):
    """Panels on the side of an obstacle that the snow meets, in rows and columns of equal ones."""

    EXAMPLES: ClassVar = {"size": 0.5, "direction": [1.0, 0.0, 0.0], "interval": 0.01}

    size: Positive
    """longest edge of a panel [m]; the face is cut into equal panels that are not larger"""
    direction: Direction
    """of the push that counts, into the obstacle: that of the flow [-]"""
    interval: Positive | None = None
    """longest time over which a pressure is a mean [s]: the time between two frames is cut into equal parts that are
    not longer; a tenth of `output.interval` when missing"""


class OfObstacle(Spec):
    """Keys of an obstacle."""

    panels: Panels | None = None
    """pressure over its face, panel by panel; method = "mpm" only"""


def asked(scene):
    """(key, value) of each."""
    for i, obstacle in enumerate(scene.obstacles):
        if obstacle.panels:
            yield f"obstacles.{i}.panels.size", obstacle.panels.size


def interval_of(scene, panels):
    """Time over which a pressure is a mean [s]."""
    between = scene.output.interval
    return between / max(1, math.ceil(between / (panels.interval or SHARE * between) - 1e-9))


def refuse(scene):
    """Raise InputError for obstacles that move, and bodies with velocities of their own at a node."""
    for key, value in asked(scene):
        obstacle = scene.obstacles[int(key.split(".")[1])]
        if obstacle.motion or obstacle.get("free"):
            raise InputError.at(key, value, "does not go with an obstacle that moves", scene.source)
        if components.velocity_fields(scene).any():
            raise InputError.at(key, value, 'does not go with bodies.contact = "separate"', scene.source)


COMPONENTS.add(Component(
    "pressure_panels", __package__, "pressure panels", asked, order=95, keys={"obstacles": OfObstacle},
    beside=('water.scheme = "v_w"',), refuse=refuse, rests=True, in_python=True,
    cautions=f"{__package__}.cautions"))

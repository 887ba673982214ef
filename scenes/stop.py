"""When a run has something to compute: from its first event on, and until its snow rests."""

import math
from typing import ClassVar

from snowmpm import components
from snowmpm.scenes.gravity import Gravity
from snowmpm.scenes.spec import Fraction, Positive, Spec


class Stop(Spec):
    """A run ends once its snow has moved and come to rest: only a small share of its mass is fast, only a small share
    of its peak momentum is left, and no event is still to come. Where neither share is given, a hundredth of the peak
    momentum is rest as well: that of films."""

    EXAMPLES: ClassVar = {"at_rest": False, "moving_share": 0.01, "momentum_share": 0.05}

    at_rest: bool | None = None
    """whether to end at rest, before end_time. When missing: yes if snow flows over a terrain (dem, mesh or profile)
    and the scene has no saw test, no reference, no obstacle that moves and no structure that another
    program computes"""
    moving_share: Fraction | None = None
    """share of the mass that may still be faster than 1 m/s [-]; 0.02 when missing"""
    momentum_share: Fraction | None = None
    """sum m |v| over its largest value, at most [-]; 0.05 when missing"""
    hold: Positive | None = None
    """time for which both must hold [s]; a twentieth of end_time when missing"""


def ends_at_rest(scene):
    """Whether a run of a scene ends when its snow has come to rest."""
    if scene.stop.at_rest is not None:
        return scene.stop.at_rest
    if scene.terrain is None or scene.saw_test or scene.reference or any(
            item.motion for item in scene.obstacles) or any(
            component.moves_on for component in components.used(scene)):
        return False
    return scene.terrain.kind in ("dem", "mesh", "profile")


def rests_until(scene):
    """Time [s] of the last frame before the first event of a scene that begins settled: until then nothing moves, and
    nothing is computed. 0 where something may move without an event, or no event comes before the end. A saw test is
    followed from its start."""
    if scene.initial.stress != "settle" or scene.saw_test or not scene.events or scene.forces or scene.switch or (
            scene.zone or isinstance(scene.gravity, Gravity)) or any(
            body.start_time > 0.0 for body in scene.bodies) or any(item.motion for item in scene.obstacles) or not all(
            component.rests for component in components.used(scene)):
        return 0.0
    first = min(event.get("start", 0.0) for event in scene.events)
    if first >= scene.end_time:
        return 0.0
    return scene.output.interval * math.floor(first / scene.output.interval * (1.0 + 1e-9))

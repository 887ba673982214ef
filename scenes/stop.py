"""When a run ends before its end_time."""

from snowmpm.scenes.spec import Fraction, Positive, Spec


class Stop(Spec):
    """A run ends once its snow has moved and come to rest: hardly any of its mass is fast, hardly anything is left of
    its largest momentum, and nothing is still to happen to it."""

    at_rest: bool | None = None
    """whether to end then, before end_time; when missing where snow flows over a terrain (dem, mesh, or a profile
    without events), unless a saw test, an answer to compare with or a moving obstacle asks for the whole time"""
    moving_share: Fraction | None = None
    """share of the mass that may still be faster than 1 m/s [-]; 0.02 when missing"""
    momentum_share: Fraction | None = None
    """sum m |v| over its largest value, at most [-]; 0.05 when missing"""
    hold: Positive | None = None
    """time that both must last [s]; a twentieth of end_time when missing"""


def ends_at_rest(scene):
    """Whether a run of a scene ends when its snow has come to rest."""
    if scene.stop.at_rest is not None:
        return scene.stop.at_rest
    if scene.terrain is None or scene.saw_test or scene.reference or any(item.motion for item in scene.obstacles):
        return False
    return scene.terrain.kind in ("dem", "mesh") or (scene.terrain.kind == "profile" and not scene.events)

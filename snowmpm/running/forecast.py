"""How many steps a run takes, and when it ends, before it runs."""

from dataclasses import dataclass
from typing import Any

from snowmpm.running.rest import HOLD
from snowmpm.scenes.stop import ends_at_rest, rests_until
from snowmpm.stepping.abilities import course as course_of
from snowmpm.stepping.abilities import expected_dt


@dataclass(frozen=True)
class Forecast:
    """steps: of the run; dt: their mean [s]; end: time at which it ends [s]; course: `depth.blocks.Course` of a method
    that knows one, else None."""

    steps: float
    dt: float
    end: float
    course: Any = None


def forecast(scene, solver):
    """`Forecast` of a scene: with a fixed step, or one as the first, until end_time; a method that knows its course
    says more."""
    # No step goes beyond a frame
    begin = rests_until(scene)
    end, first = scene.end_time, scene.solver.dt or min(expected_dt(solver)[0], scene.output.interval)
    course = course_of(solver, end, scene.output.interval)
    if course is None:
        return Forecast((end - begin) / first, first, end)
    if ends_at_rest(scene):
        end = min(end, course.rests + (scene.stop.hold or HOLD * end))
    steps = course.steps + max(0.0, end - course.rests) / course.last
    return Forecast(end / scene.solver.dt, scene.solver.dt, end, course) if scene.solver.dt else Forecast(
        steps, end / steps, end, course)

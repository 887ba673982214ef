"""The answer of a run to a question, by the definitions of `snowmpm.ladder.questions`."""

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.io.impact import WINDOW, loaded
from snowmpm.ladder.questions import SLIDES

STANDARD = 9.81
"""Gravity of a scene that says nothing [m/s2]."""
MOST_POINTS = 2000
"""Particles at which the depth of the snow is looked up, about."""


def answer_of(run, ask):
    """Value of the answer of a `Run`; None where the run has none. Raises SimulationError for a run that broke off."""
    if not run.complete:
        raise SimulationError(f"{run.path}: broke off before its end")
    return FROM_RUN[ask.question.name](run, ask)


def _runout(run, ask):
    numbers = run.hazard.get("numbers", {})
    if "reach_of_flow" in numbers:
        return numbers["reach_of_flow"]
    return float(np.nanmax(run.history["front_distance"])) if "front_distance" in run.history else None


def _number(name):
    return lambda run, ask: run.hazard.get("numbers", {}).get(name)


def _pressure(run, ask):
    raster = run.maps.get("peak_pressure")
    return None if raster is None else float(np.nan_to_num(raster.nearest([ask.place - run.origin[:2]])[0]))


def _load(run, ask):
    chosen = [one for name, one in run.obstacles.items() if ask.obstacle in (None, name)]
    if not chosen:
        return None
    share = 0.0 if run.scene["solver"].get("method") == "depth" else WINDOW
    together = _Sum(chosen[0].time, sum(one.impulse for one in chosen))
    found = loaded(together, share)
    return found.peak if found else 0.0


class _Sum:
    """Obstacles that bear together. time (n,) [s], impulse (n, 3) [N s]."""

    def __init__(self, time, impulse):
        self.time, self.impulse = time, impulse


def _saw(name):
    return lambda run, ask: run.summary.get("saw_test", {}).get(name)


def _release(run, ask):
    history = run.history
    limit = SLIDES**2 * _gravity(run) * _depth(run)
    return float((2.0 * history["kinetic_energy"] / np.maximum(history["mass"], 1e-30)).max() > limit)


def _depth(run):
    """Depth of the snow at the start [m]."""
    points = run.frame(0, []).positions
    if run.terrain is None:
        return float(np.ptp(points[:, -1]))
    if run.dimension == 2:
        ground = run.terrain.vertices[np.argsort(run.terrain.vertices[:, 0])]
        return float((points[:, -1] - np.interp(points[:, 0], ground[:, 0], ground[:, -1])).max())
    some = points[:: max(1, len(points) // MOST_POINTS)]
    return float(np.nanmax(some[:, -1] - run.terrain.heights(some[:, :2])))


def _gravity(run):
    """Size of gravity [m/s2]."""
    given = run.scene.get("gravity", STANDARD)
    return float(np.linalg.norm(given.get("value", STANDARD) if isinstance(given, dict) else given))


def _settlement(run, ask):
    energy, mass = run.history["potential_energy"], run.history["mass"][0]
    return float((energy[0] - energy[-1]) / (mass * _gravity(run))) if _gravity(run) > 0.0 else None


FROM_RUN = {
    "run-out": _runout, "affected-area": _number("affected_area"), "peak-pressure": _pressure, "load": _load,
    "deposit-volume": _number("deposit_volume"), "critical-length": _saw("critical_length"),
    "crack-speed": _saw("crack_speed"), "release": _release, "settlement": _settlement,
}
"""Questions that a run answers; a factor of safety takes several."""

"""Records of saw tests made by hand."""

import numpy as np

from snowmpm.saw_test.result import result_of

D, SAW = 0.5, 2.0


def record(arrival_of, length=6.0, n=240, saw_to=1.0, settled=1.2e-3, until=0.6):
    """A crack that reaches x at arrival_of(x), NaN where it never does; a saw of 2 m/s from time 0."""
    x = (np.arange(n) + 0.5) * length / n
    time = np.linspace(0.0, until, 1201)
    arrival = np.array([arrival_of(at) for at in x])
    arrival = np.where(arrival <= until, arrival, np.nan)
    saw = np.minimum(SAW * time, saw_to)
    broken = (arrival <= time[:, None]) | (x < saw[:, None])
    tip = length / n * np.argmin(np.column_stack([broken, np.zeros(len(time), bool)]), axis=1)
    settlement = np.where(broken, settled, 0.0)
    return {"x": x, "time": time, "saw": saw, "tip": tip, "arrival": arrival, "settlement": settlement,
            "fracture_energy": np.where(np.isfinite(arrival), 0.9, np.nan), "plastic_work": np.linspace(0.0, 5.0, 1201)}


def found(record):
    return result_of(record, slab_thickness=D, saw_speed=SAW)


def runaway(at):
    """With the saw to 0.3 m, then at 30 m/s."""
    return at / SAW if at < 0.3 else 0.15 + (at - 0.3) / 30.0

"""Mass of snow and of water over a run: what is there, what left, and what came."""

import numpy as np


def audited(simulation, end, every=1):
    """Rows of the audit now, after each `every` steps until `end` [s], and there."""
    rows = [simulation.audit()]
    while simulation.time < end:
        simulation.step(until=end)
        if simulation.solver.steps % every == 0 or simulation.time >= end:
            rows.append(simulation.audit())
    return rows


def assert_masses_close(rows, tolerance=1e-10):
    """Of snow without water and of water, in each row of an audit, over what there was or came; -> how many rows."""
    def of(name):
        return np.array([row[name] for row in rows])

    snow = of("mass") - of("water_mass") + of("removed_mass") - of("removed_water")
    np.testing.assert_allclose(snow, snow[0], rtol=tolerance)
    water = of("water_mass") + of("removed_water") + of("drained_water") - of("added_water")
    size = max(of("water_mass").max(), of("added_water").max())
    assert size > 0.0
    np.testing.assert_allclose(water, water[0], rtol=0.0, atol=tolerance * size)
    assert of("water_residual").max() < tolerance
    return len(rows)

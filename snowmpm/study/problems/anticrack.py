"""A crack that runs by itself through the weak layer of a saw test on the flat (S2, S3): what its collapse leaves.

The column of pst_2d (slab of 0.5 m, 250 kg/m3, 3 MPa) on the weak layer W3: the card gaume_weak_layer, 50 mm, drawn two
cells thick. Behind the crack the slab rests, and what the layer has become is on its oedometric curve P(e): with sigma
the weight of the slab and e the shortening beyond the softening branch at which P(e) = sigma, it has settled by t e;
the work until its bonds were broken is t times the integral of P de to the end of softening. Both hold for any speed of
the crack, of which no exact value is known.
"""

import functools

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.saw_test import theory

SLAB = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
WEAK_LAYER = {"materials.weak_layer": {"card": "gaume_weak_layer"}}
SLAB_HEIGHT, LENGTH = 0.5, 3.0
"""Of the slab, and of the column [m]: shorter ones have no part that the ends leave alone."""
AFTER = 0.05
"""Of the run after the crack has come through [s]: the slab lands."""
SPARE = 0.05
"""Of the end of the column [m], where the last bins may not break."""


@functools.cache
def exact():
    """Settlement [m] and work of collapse [J/m2] of the weak layer."""
    from snowmpm.saw_test.prediction import column_of
    from snowmpm.scenes import load_scene

    scene = load_scene("pst_2d", WEAK_LAYER)
    slab, law, thickness = column_of(scene)
    e, P, _, _ = theory.collapse_curve(law)
    load = slab.stresses(0.0, scene.gravity)[0]
    peak = int(np.argmax(np.diff(P) < 0.0))
    lowest = peak + int(np.argmin(P[peak:]))
    return thickness * float(np.interp(load, P[lowest:], e[lowest:])), theory.fracture_energy(law, thickness)


def collapse_error(scheme, cells, per_axis=2):
    """Root mean square of the relative errors of settlement and work; nan where no crack runs by itself. cells: in the
    height of the slab."""
    simulation = scheme.simulation("pst_2d", SLAB_HEIGHT / cells, per_axis, {
        **WEAK_LAYER, "initial.stress": "geostatic", "saw_test.length": LENGTH})
    end = simulation.scene.end_time
    while simulation.time < end:
        simulation.step()
        if simulation.crack.rows["tip"][-1] >= LENGTH - SPARE:
            end = min(end, simulation.time + AFTER)
    found = simulation.crack.result()
    if found["collapse_height"] is None:
        return float("nan")
    return np.sqrt(np.mean((np.array([found["collapse_height"], found["fracture_energy"]]) / exact() - 1.0) ** 2))

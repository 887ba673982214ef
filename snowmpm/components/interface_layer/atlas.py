"""Entry: cells too coarse for the slab above an interface."""

import functools

from snowmpm.scenes import load_scene
from snowmpm.study.atlas.entry import Entry

THICKNESS, SLAB = 0.05, 0.5
"""Of the weak layer and of the slab [m]."""
FINEST = 10.0
"""Cells over the slab of the reference, which are as wide as the layer is thick."""
POINT = 0.0156
"""Distance of points, about [m]."""
SLOW = 0.1
"""Limit of the entry."""


def crack_speed_error(cells, transfer="aflip"):
    """Speed of a crack under a slab of so many cells over that of `FINEST` with AFLIP, less 1."""
    return _speed(cells, transfer) / _speed(FINEST, "aflip") - 1.0


@functools.cache
def _speed(cells, transfer):
    from snowmpm.running.simulation import Simulation  # it builds a scene, which most entries do not

    dx = SLAB / cells
    scene = load_scene("pst_2d", {
        "solver.dx": dx, "solver.transfer": transfer, "saw_test.length": 4.0, "saw_test.notch": 0.3,
        "saw_test.saw_start": 0.0, "materials.weak_layer": {"card": "gaume_weak_layer"}, "initial.stress": "geostatic",
        "saw_test.weak_layer": {"material": "weak_layer", "thickness": THICKNESS,
                                "interface": max(1, round(dx / POINT))}})
    simulation = Simulation(scene)
    while simulation.time < scene.end_time and simulation.crack.rows["tip"][-1] < 4.0 - 1e-9:
        simulation.step()
    return simulation.crack.result()["crack_speed"] or 0.0  # none: it did not run


ENTRIES = (
    Entry(
        name="coarse_interface", title="A crack under too few cells",
        scene="A saw test of 4 m whose weak layer of 5 cm is an interface, under a slab of 0.5 m, on the flat",
        seen="The crack runs, after the same cut and with the same energy, but slower: waves of the slab that are"
             " shorter than some cells lag on a grid that lumps the mass at its nodes",
        cure="a solver.dx of at most a quarter of the slab's thickness", parameter="cells over the slab",
        unit="cells", values=(2.0, 3.0, 4.0, 5.0, 6.5, 8.0), fails="below",
        settings={"aflip": {}, "flip": {"transfer": "flip"}},
        symptom="speed of the crack over that on fine cells, less 1", limit=SLOW, measure=crack_speed_error,
        shown="aflip", resolution=0.1),
)

ATLAS = {"materials and layers": ENTRIES}

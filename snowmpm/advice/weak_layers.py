"""Weak layers of a scene, and the grids that they bear.

A crack needs cells to run through. The layer collapses a row of cells at a time, so with softening as given the energy
of breaking goes with dx (atlas: softening_on_grid): a scene whose softening was chosen on one grid is another scene on
a coarser one, whose cuts are too short, or on a finer one, whose layer may fail by itself.
"""

from dataclasses import dataclass

from snowmpm.components import carried

LEAST_CELLS = 2.0
"""Cells through a weak layer: on one, slab_release_resolved stands still after its cut."""
SLACK = 1e-6
"""Round-off of a thickness over a spacing."""


@dataclass(frozen=True)
class WeakLayer:
    """A body whose bonds break under compression: index, name, material; thickness [m], inf where only the particles
    tell; tuned: its softening counts for the grid that it was chosen on."""

    body: int
    name: str
    material: str
    thickness: float
    tuned: bool


def weak_layers(scene):
    """`WeakLayer`s of a scene that need cells: not those that a saw test draws some cells thick, which follow the grid,
    nor those that a component carries, which have none."""
    test = scene.saw_test
    drawn = test is not None and test.weak_layer.cells is not None
    found = []
    for i, body in enumerate(scene.bodies):
        law = scene.materials[body.material]
        if law.collapses and not carried(scene, body) and not (drawn and body.name == "weak_layer"):
            found.append(WeakLayer(i, body.name, body.material, body.shape.thickness, law.collapse_thickness is None))
    return found


def coarsest_dx(scene):
    """Largest dx [m] that leaves each weak layer LEAST_CELLS; inf without one."""
    return min((layer.thickness / LEAST_CELLS * (1.0 + SLACK) for layer in weak_layers(scene)),
               default=float("inf"))


def tuned_to_grid(scene):
    """The first weak layer whose softening counts for one grid only; None without."""
    return next((layer for layer in weak_layers(scene) if layer.tuned), None)

"""Entries: strength that follows a strain averaged over a length, with few cells over it and beside a wall."""

from snowmpm.components.nonlocal_averaging.layer import LENGTH, STRIP, Layer, sheared
from snowmpm.study.atlas.entry import Entry
from snowmpm.study.problems.schemes import APIC, Scheme

HEIGHT, SECONDS, CELLS = 4.0 * LENGTH, 0.5, 6
"""Of the layer [m], of the way of its walls [s], over the length where the wall is what matters."""
SHORT, BESIDE = 0.2, 0.1
"""Limits of the entries below."""
SPH = Scheme("", method="sph")


def work_of_cells(cells, scheme):
    """Work of softening with so many cells over the length, over that of the length, less 1."""
    dx = LENGTH / cells
    return sheared(Layer(dx, scheme=scheme, height=2.0 * dx * round(0.5 * HEIGHT / dx), seconds=SECONDS)).softened - 1.0


def work_beside_wall(distance, walls):
    """Work of softening of a strip whose nearer side is `distance` lengths from a wall, over that in the middle, less
    1."""
    middle = (distance * LENGTH + 0.5 * STRIP) - 0.5 * HEIGHT
    beside, within = (sheared(Layer(LENGTH / CELLS, height=HEIGHT, middle=at, walls=walls, seconds=SECONDS)).softened
                      for at in (middle, 0.0))
    return beside / within - 1.0


ENTRIES = (
    Entry(
        name="averaging_on_grid", title="Few cells over the length of an average",
        scene="A layer of clay that softens, sheared between rigid walls until it has slipped on one band",
        seen="The cells that slip add their own thickness to the length: a band that softens takes too much work",
        cure="four cells or more over nonlocal_length, or, where all shear is in bands, a longer one with a"
             " softening_strain that is shorter in proportion",
        parameter="cells over the length", unit="", values=(2.0, 3.0, 4.0, 6.0, 8.0), fails="below",
        settings={"mpm": {"scheme": APIC}, "sph": {"scheme": SPH}},
        symptom="work of softening over that of the length, less 1", limit=SHORT, measure=work_of_cells, shown="mpm",
        resolution=0.1),
    Entry(
        name="averaging_at_wall", title="An average that ends at a wall",
        scene="The same layer, whose weak strip lies near a wall",
        seen="Beside a wall or a free surface the average is over the material on one side: a band there loses strength"
             " sooner, and takes less work",
        cure="a length over which the band keeps its distance, or a wall of particles of a law with the same"
             " nonlocal_length",
        parameter="distance over the length", unit="", values=(0.0, 0.125, 0.25, 0.5, 0.75, 1.0), fails="below",
        settings={"rigid wall": {"walls": "elastic"}, "wall with the same length": {"walls": "clay"}},
        symptom="work of softening over that far away, less 1", limit=BESIDE, measure=work_beside_wall,
        shown="rigid wall", cured="wall with the same length", resolution=0.1),
)

ATLAS = {"materials and layers": ENTRIES}

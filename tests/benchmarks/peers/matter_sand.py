"""The slice of sand by matter.

    python matter_sand.py GRIDS SOURCES       # SOURCES: a checkout of github.com/larsblatny/matter

Its own test begins half a cell above the floor; here the sand lies on it, as for the others.
"""

import itertools
import sys
import tempfile

import numpy as np
from matter_code import CHOICES, compiled, run
from sand_slice import CELLS, DENSITY, HEIGHT, TIME, YOUNGS_MODULUS, lattice, tell

with tempfile.TemporaryDirectory() as made:
    program = compiled(sys.argv[2], made, 3)
    for choice, cells in itertools.product(CHOICES, CELLS[: int(sys.argv[1])]):
        dx = HEIGHT / cells
        x = lattice(dx)
        seconds, found = run(program, "sand", dx, choice, TIME, x, np.zeros_like(x))
        steps = int(np.ceil(TIME * np.sqrt(YOUNGS_MODULUS / DENSITY) / (0.5 * dx)))
        tell("matter", choice, cells, len(x), steps, seconds, found[:, 0])

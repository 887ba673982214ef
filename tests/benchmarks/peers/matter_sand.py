"""The slice of sand by matter.

    python matter_sand.py GRIDS SOURCES       # SOURCES: a checkout of github.com/larsblatny/matter
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
        x[:, 1] += 0.5 * dx  # as its own test has it: nodes on the floor stand still
        seconds, found = run(program, "sand", dx, choice, TIME, x, np.zeros_like(x))
        steps = int(np.ceil(TIME * np.sqrt(YOUNGS_MODULUS / DENSITY) / (0.5 * dx)))
        tell("matter", choice, cells, len(x), steps, seconds, found[:, 0])

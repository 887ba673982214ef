"""The free bar by matter, in plane strain and 3-D, by quadratic and cubic splines.

    python matter_bar.py GRIDS SOURCES       # SOURCES: a checkout of github.com/larsblatny/matter
"""

import itertools
import sys
import tempfile

import numpy as np
from free_bar import CELLS, LENGTH, PERIOD, SPEED, error, lattice, start, tell
from matter_code import CHOICES, compiled, run

with tempfile.TemporaryDirectory() as made:
    for dim, degree in itertools.product((2, 3), (2, 3)):
        program = compiled(sys.argv[2], made, dim, degree)
        for choice, cells in itertools.product(CHOICES, CELLS[: int(sys.argv[1])]):
            x = lattice(0.5 * LENGTH / cells, dim)
            v = np.zeros_like(x)
            v[:, 0] = start(x[:, 0])
            seconds, found = run(program, "bar", cells, choice, PERIOD, x, v)
            steps = int(np.ceil(PERIOD * SPEED / (0.5 * LENGTH / cells)))
            tell("matter", f"{choice}, {'quadratic' if degree == 2 else 'cubic'}", dim, cells, len(x), steps, seconds,
                 error(x[:, 0], found[:, 1]))

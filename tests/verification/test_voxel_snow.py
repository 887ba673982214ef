"""Voxel snow with breaking ice in pull, shear, push and between: peaks of three made samples (E16).

`tests/benchmarks/voxel_snow.py` makes the table that the fast tests read. Gates were written before the first run:

- Ice bears a third in tension of what it bears in compression, and skeletons break where they bend: pull and shear
  below push. No order of pull and shear: on a Coulomb line of a slope below 1 the tension at its apex is the larger.
- The domain of loads that a skeleton of one associated law bears is convex (limit analysis), and closed since pores can
  be crushed. Ice that softens and does not dilate may be off: 10 %.
- Push strengthens in shear and pull weakens, as in the fits of Mede et al. (2018).
- In units of the strength in push, strengths from shear to push lie between the least and the largest of those fits.
- Pull is at most the apex of the straight part of a fit.
- Half the rate of the load: 10 %. Cells of two thirds: 15 %, as told in the library's scene.
- Absolute strengths within published ones: pull between Sigrist and Adam, shear within a factor of 2 of Jamieson and
  Johnston's rounded grains.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from tests.support.mede import MEDE
from tests.support.voxel_snow import FRACTION, PATHS

TABLE = Path(__file__).parents[1] / "benchmarks" / "figures" / "voxel_snow.csv"
MIXED = ("shear", "shear and push", "as much push", "push and shear")
CONVEX, RATE, CELLS = 0.10, 0.10, 0.15

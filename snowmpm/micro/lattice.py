"""The lattice D3Q19: 19 velocities e_i [voxels a step] and their weights w_i (Qian et al. 1992,
doi:10.1209/0295-5075/17/6/001). Velocity 0 rests; 2k - 1 and 2k are opposite."""

import numpy as np

_HALF = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)]

VELOCITIES = np.array([(0, 0, 0), *(tuple(sign * c for c in e) for e in _HALF for sign in (1, -1))])
WEIGHTS = np.array([1 / 3, *(1 / 18 if abs(e).sum() == 1 else 1 / 36 for e in VELOCITIES[1:])])
PAIRS = len(_HALF)

"""Traction and permeability of a layer of grains along a path of jumps, learnt from driven cells.

The path says the present by five numbers: the jump now, normal u_n and tangential u_t, and the farthest closing,
opening and slip so far, each as asinh(u / u_0), so that both the break of the bonds and the collapse of the pores, at
ten times its jump, are wide. A Gaussian process each goes through T_n, T_t and the logarithms of k_n, k_t.

A cell is path-dependent in more than five numbers. What they leave out is noise to the process, and the error on paths
that were not learnt (`unseen_errors`) is its measure.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.micro.gaussian_process import GaussianProcess
from snowmpm.micro.grains.curves import jump_path
from snowmpm.micro.grains.pore_space import cell_permeability

ROWS = 40
"""Of a path that are learnt."""

AT_END = 1e-3
"""A cell's way is shorter than that asked for by a share of this: its steps are multiplied, not added."""

NORMAL = 1.959963984540054
"""Standard deviations of a 95 % interval."""


@dataclass(frozen=True)
class LearntPath:
    """jump (n, 2): normal, positive opening, and tangential, over the height of the layer; traction (n, 2) [Pa] alike,
    tension positive; at (m,): rows with permeability (m, 2) [m2], along and across the normal."""

    jump: np.ndarray
    traction: np.ndarray
    at: np.ndarray
    permeability: np.ndarray

    def thinned(self):
        """About `ROWS` rows of it, at equal ways in the state over its range and in traction over its largest."""
        state = _state(self.jump, max(1e-12, 1e-2 * float(np.abs(self.jump).max())))
        parts = state / np.maximum(np.ptp(state, axis=0), 1e-300), self.traction / np.abs(self.traction).max()
        way = sum(np.linalg.norm(np.diff(part, axis=0), axis=1) for part in parts)
        along = np.concatenate([[0.0], np.cumsum(way)])
        kept = np.searchsorted(along, np.linspace(0.0, along[-1], ROWS)).clip(0, len(along) - 1)
        return np.unique(kept)


def random_jumps(count, closing, rng, legs=3):
    """Turning points (legs, 2) of `count` paths: normal jumps between -closing and a tenth of it in opening, tangential
    ones up to half of it either way; each leg goes on or back."""
    low, high = np.array([-closing, -0.5 * closing]), np.array([0.1 * closing, 0.5 * closing])
    return low + (high - low) * rng.random((count, legs, 2))


def learnt_path(sample, jumps, voxels=None, looks=4):
    """`LearntPath` of a copy of a sample (`Assembly`) along jumps (k, 2). voxels: along x, for the permeability, which
    is looked at so often on equal ways; None: without."""
    jumps = np.asarray(jumps, float)
    whole = np.linalg.norm(np.diff(np.vstack([[0.0, 0.0], jumps]), axis=0), axis=1).sum()
    seen, rows, way = [], [0], [0.0]
    last = np.zeros(2)

    def look(cell):
        nonlocal last
        now = cell.deformation[[2, 0], 2] - [1.0, 0.0]
        way.append(way[-1] + float(np.linalg.norm(now - last)))
        last = now
        rows[0] += 1
        if voxels and way[-1] >= (len(seen) + 1) * whole / looks * (1.0 - AT_END):
            seen.append((rows[0], *cell_permeability(cell, voxels)))

    if voxels:
        seen_first = (0, *cell_permeability(sample, voxels))
    curve = jump_path(sample, jumps, "path", look=look)
    table = np.array([seen_first, *seen]) if voxels else np.zeros((0, 3))
    return LearntPath(curve.jump[:, [2, 0]], curve.traction[:, [2, 0]], table[:, 0].astype(int), table[:, 1:])


class Surrogate:
    """Learnt from `LearntPath`s of one sample.

    scale u_0: the jump at which the normal traction of the first path is largest, so that path should close or open.
    """

    def __init__(self, paths):
        first = paths[0]
        self.scale = max(1e-9, float(np.abs(first.jump[int(np.abs(first.traction[:, 0]).argmax())]).max()))
        kept = [path.thinned() for path in paths]
        states = np.concatenate([_state(path.jump, self.scale)[rows] for path, rows in zip(paths, kept, strict=True)])
        tractions = np.concatenate([path.traction[rows] for path, rows in zip(paths, kept, strict=True)])
        self._tractions = [GaussianProcess(states, tractions[:, k]) for k in range(2)]
        self._range = states.min(axis=0), states.max(axis=0)
        wet = [path for path in paths if len(path.at)]
        self._pores = []
        if wet:
            states = np.concatenate([_state(path.jump, self.scale)[path.at] for path in wet])
            values = np.log(np.concatenate([path.permeability for path in wet]))
            self._pores = [GaussianProcess(states, values[:, k]) for k in range(2)]

    def traction(self, jumps):
        """T (n, 2) [Pa] along a path of jumps (n, 2) that begins at rest, and standard deviations (n, 2)."""
        found = [process(_state(jumps, self.scale)) for process in self._tractions]
        return tuple(np.stack(part, axis=1) for part in zip(*found, strict=True))

    def permeability(self, jumps):
        """k (n, 2) [m2] along a path, and the factors (n, 2) of one standard deviation. ValueError of a surrogate that
        has learnt none."""
        if not self._pores:
            raise ValueError("learnt from paths without permeability")
        found = [process(_state(jumps, self.scale)) for process in self._pores]
        return tuple(np.exp(np.stack(part, axis=1)) for part in zip(*found, strict=True))

    def knows(self, jumps):
        """(n,): whether each of the five numbers of a path is within those that were learnt. Beyond, the process goes
        back to the mean, and only its standard deviation says so."""
        state = _state(jumps, self.scale)
        return ((state >= self._range[0]) & (state <= self._range[1])).all(axis=1)


def unseen_errors(surrogate, path):
    """Of a `LearntPath` that was not learnt: traction: root mean square difference over the way of the jump, over the
    largest traction of the path; covered: share of its tractions within the 95 % intervals; permeability: root mean
    square of the logarithm of the ratio, NaN of a path without."""
    found, spread = surrogate.traction(path.jump)
    steps = np.linalg.norm(np.diff(path.jump, axis=0), axis=1)
    way = np.gradient(np.concatenate([[0.0], np.cumsum(steps)]))
    square = ((found - path.traction) ** 2).sum(axis=1)
    largest = float(np.linalg.norm(path.traction, axis=1).max())
    covered = (np.abs(found - path.traction) < NORMAL * spread) * way[:, None]
    pores = np.nan
    if len(path.at):
        ratio = np.log(surrogate.permeability(path.jump)[0][path.at] / path.permeability)
        pores = float(np.sqrt((ratio**2).mean()))
    return {"traction": float(np.sqrt((square * way).sum() / way.sum())) / largest,
            "covered": float(covered.sum() / (2.0 * way.sum())), "permeability": pores}


def _state(jumps, scale):
    """The five numbers (n, 5) of a path of jumps (n, 2)."""
    normal, slip = np.asarray(jumps, float).T
    sides = np.maximum(-normal, 0.0), np.maximum(normal, 0.0), np.abs(slip)
    farthest = [np.maximum.accumulate(part) for part in sides]
    return np.arcsinh(np.stack([normal, slip, *farthest], axis=1) / scale)

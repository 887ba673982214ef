"""Tests of a cell of bonded grains: what it bears along a path of deformation.

A weak layer of height h between rigid faces with a jump u of the displacement and the normal N = z deforms as

    F = I + u x N / h,   traction T = P N = J sigma F^-T N        (P: first Piola-Kirchhoff stress)

(Sun, Andrade and Rudnicki 2011, doi:10.1002/nme.3220; Wang and Sun 2018, doi:10.1016/j.cma.2018.01.036). The cell is
periodic, so that the work of T on u is that of the contacts (Hill and Mandel).
"""

import copy
from dataclasses import dataclass

import numpy as np

from snowmpm.micro.grains.drive import compress, drive

GENTLE, BRISK = 1e-6, 1e-5
"""Strain of a step while the bonds hold, and once they have failed."""

FAILED = 0.7
"""Share of the bonds below which a sample has failed."""

EVERY = 24
"""Steps between two rows of a curve."""

FAR = 8.0
"""Way of the tests that end soon, over half of that at which closing bears most."""

DRAG = 0.005
"""Share of its velocity that a grain loses in a step."""


@dataclass(frozen=True)
class DrivenCurve:
    """deformation F (n, 3, 3) of the cell, stress (n, 3, 3) [Pa], Cauchy's, tension positive, bonds (n,): share that
    holds; the first row is the sample at rest."""

    name: str
    deformation: np.ndarray
    stress: np.ndarray
    bonds: np.ndarray

    @property
    def traction(self):
        """T (n, 3) [Pa] on planes that were normal to z, per area before the deformation."""
        J = np.linalg.det(self.deformation)
        return J[:, None] * np.einsum("nij,njk,k->ni", self.stress, np.linalg.inv(self.deformation).transpose(0, 2, 1),
                                      np.array([0.0, 0.0, 1.0]))

    @property
    def jump(self):
        """u / h (n, 3): what planes that were normal to z moved against each other, over their distance."""
        return self.deformation[:, :, 2] - np.array([0.0, 0.0, 1.0])

    def thinned(self, rows):
        """About so many rows of it, at equal ways in strain over its largest and stress over its largest."""
        parts = [self.deformation - np.eye(3), self.stress]
        way = np.zeros(len(self.bonds))
        for part in parts:
            flat = part.reshape(len(part), 9)
            scale = max(float(np.linalg.norm(flat, axis=1).max()), 1e-300)
            way[1:] += np.linalg.norm(np.diff(flat, axis=0), axis=1) / scale
        along = np.cumsum(way)
        kept = np.unique(np.searchsorted(along, np.linspace(0.0, along[-1], rows)).clip(0, len(way) - 1))
        return DrivenCurve(self.name, self.deformation[kept], self.stress[kept], self.bonds[kept])


class _Record:
    """Rows of a curve while a cell is driven."""

    def __init__(self, cell):
        self.cell, self.made, self.rows = cell, max(1, cell.bonds), []
        self.take()

    def take(self):
        """A row of the cell as it is; -> share of the bonds that holds."""
        stress, share = self.cell.stress(), self.cell.bonds / self.made
        self.rows.append((self.cell.deformation.copy(), 0.5 * (stress + stress.T), share))
        return share

    def curve(self, name):
        """`DrivenCurve` of the rows."""
        return DrivenCurve(name, *(np.array(column) for column in zip(*self.rows, strict=True)))


def driven_path(sample, deformations, name, stop_failed=False, look=None):
    """`DrivenCurve` of a copy of a sample (`Assembly`) whose cell is deformed from I to each F of (k, 3, 3) in turn, in
    straight lines: diagonal, F_xz and F_yz. stop_failed: end where the sample has failed. look(cell): called at each
    row but the first."""
    cell = copy.deepcopy(sample)
    cell.damping = DRAG / cell.dt
    record, share, before = _Record(cell), 1.0, np.eye(3)
    for target in np.asarray(deformations, float):
        length, done = float(np.linalg.norm(target - before)), 0.0
        while done < 1.0 and not (stop_failed and share < FAILED):
            done = min(1.0, done + EVERY * (BRISK if share < FAILED else GENTLE) / max(length, 1e-12))
            towards(cell, before + done * (target - before))
            share = record.take()
            if look is not None:
                look(cell)
        before = target
    return record.curve(name)


def jump_path(sample, jumps, name, stop_failed=False, look=None):
    """`driven_path` of jumps (k, 2): normal and tangential, over the height of the cell.

    (-0.1, 0) closes the layer by a tenth, which is the oedometer; (0.1, 0) opens it, (0, 0.1) shears it at constant
    volume.
    """
    normal, tangential = np.asarray(jumps, float).T
    deformations = np.tile(np.eye(3), (len(normal), 1, 1))
    deformations[:, 2, 2] += normal
    deformations[:, 0, 2] = tangential
    return driven_path(sample, deformations, name, stop_failed, look)


def towards(cell, F):
    """Deform a cell to F in `EVERY` steps."""
    L = (F @ np.linalg.inv(cell.deformation) - np.eye(3)) / (EVERY * cell.dt)
    cell.rates[:], cell.shear[:] = np.diag(L), L[:2, 2]
    cell.step(EVERY)


def triaxial(sample, pressure, strain, name="triaxial"):
    """`DrivenCurve` of a copy of a sample that is brought to a pressure [Pa], alike on all sides, and compressed along
    z to a logarithmic strain, or until it has failed, while the pressure on its sides stays."""
    cell = copy.deepcopy(sample)
    cell.damping = DRAG / cell.dt
    record = _Record(cell)
    fastest = BRISK / cell.dt
    compress(cell, pressure, fastest=fastest, tolerance=0.02)
    record.take()
    drive(cell, strain, rates=(None, None, -GENTLE / cell.dt), stresses=(-pressure, -pressure, None), fastest=fastest,
          watch=lambda one: record.take() < FAILED)
    return record.curve(name)


def driven_tests(sample, closing=0.2, pressure=None):
    """The `DrivenCurve`s from which a law is made: closing to `closing` with an unloading on the way (oedometer),
    closing with as much shear, shear at constant volume, opening, compression alike along all axes, and triaxial
    compression under a fifth of the largest stress of closing, or under `pressure` [Pa].

    All but the first end when the bonds have failed.
    """
    trial = jump_path(sample, [(-0.5 * closing, 0.0)], "trial", stop_failed=True)
    largest = int(np.argmin(trial.stress[:, 2, 2]))
    half = 0.5 * float(trial.jump[largest, 2])
    far = FAR * abs(half)
    curves = [jump_path(sample, [(half, 0.0), (0.5 * half, 0.0), (-closing, 0.0)], "closing"),
              jump_path(sample, [(-far, far)], "closing and shear", stop_failed=True),
              jump_path(sample, [(0.0, far)], "shear", stop_failed=True),
              jump_path(sample, [(far, 0.0)], "opening", stop_failed=True),
              driven_path(sample, [(1.0 - far) * np.eye(3)], "all sides", stop_failed=True)]
    if pressure is None:
        pressure = -0.2 * float(trial.stress[largest, 2, 2])
    return [*curves, triaxial(sample, pressure, far)]

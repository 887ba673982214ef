"""Cells of grains at a few particles of a 2-D run of MPM: beside the law, or in its place.

A cell takes the deformation gradient F of its particle, F' = C F with the velocity gradient C that the law sees. A cell
stretches along its axes and shears along z, so F = Q T is cut into a turn Q and an upper triangle T (Gram and Schmidt);
the stress that the cell has after T is turned back, which is exact, since a turn of all grains changes none of their
contacts:

    sigma = Q sigma(T) Q^T,   Kirchhoff's tau = det F sigma

For checks: one cell of 200 grains costs as much as many thousand particles. Cells begin free of stress and at rest, so
the run should, too. Nothing of them goes into checkpoints, nor into the energies that the audit knows.
"""

import copy

import numpy as np

from snowmpm.materials.symmetric import pack, unpack
from snowmpm.micro.grains.curves import BRISK, DRAG, EVERY, FAILED, GENTLE, towards

PLANE = np.ix_([0, 2], [0, 2])
"""Of the section of a 2-D run, x and z, in a tensor of the cell."""

STORE = [0, 2, 1]
"""Axes of the cell in the order in which a 2-D run has them: x, z, out of plane."""


class CellPoint:
    """A copy of a sample (`Assembly`) that follows a deformation gradient in plane strain."""

    def __init__(self, sample):
        self.cell = copy.deepcopy(sample)
        self.cell.damping = DRAG / self.cell.dt
        self._bonds = max(1, sample.bonds)

    @property
    def bonds(self):
        """Share of the bonds that holds."""
        return self.cell.bonds / self._bonds

    def deform(self, F):
        """Cauchy stress (3, 3) [Pa] at F (2, 2) of x and z, reached in a straight line from the last one. ValueError
        for det F <= 0."""
        turn, triangle = upper_triangle(F)
        before, target = self.cell.deformation.copy(), np.eye(3)
        target[PLANE] = triangle
        length, done = float(np.linalg.norm(target - before)), 0.0
        while done < 1.0:
            pace = BRISK if self.bonds < FAILED else GENTLE
            done = min(1.0, done + EVERY * pace / max(length, 1e-12))
            towards(self.cell, before + done * (target - before))
        Q = np.eye(3)
        Q[PLANE] = turn
        stress = self.cell.stress()
        return Q @ (0.5 * (stress + stress.T)) @ Q.T


def upper_triangle(F):
    """Rotation Q and upper triangle T (2, 2), F = Q T. ValueError for det F <= 0."""
    F = np.asarray(F, float)
    if not np.linalg.det(F) > 0.0:
        raise ValueError(f"det F = {np.linalg.det(F):g}: must be > 0")
    turn, triangle = np.linalg.qr(F)
    signs = np.sign(np.diag(triangle))
    return turn * signs, signs[:, None] * triangle


class CellsBeside:
    """Cells at particles of a `Simulation`, a copy of one sample each.

    numbers (k,): of the particles, their `id`. acting: the stress of the cells takes the place of the law's, which is
    computed on all the same. After each step deformation F (k, 2, 2) and stress (k, 3, 3), Cauchy's [Pa], x, y, z, are
    those of the cells; law (k, 3, 3) is what the law said. Raises ValueError for a run in 3-D, another method than MPM,
    gradients that the law sees otherwise, and numbers that no particle has.
    """

    def __init__(self, simulation, sample, numbers, acting=False):
        store = simulation.solver.particles
        scene = simulation.scene
        if scene.dimension != 2 or scene.solver.method != "mpm" or store.layout.more:
            raise ValueError("cells beside a law need MPM in 2-D, without a component that changes strains")
        self.simulation, self.acting, self.numbers = simulation, acting, np.asarray(numbers)
        if not np.isin(self.numbers, store.labels()[:, 1]).all():
            raise ValueError(f"numbers = {self.numbers.tolist()}: there are no such particles")
        self.points = [CellPoint(sample) for _ in self.numbers]
        self.deformation = np.tile(np.eye(2), (len(self.points), 1, 1))
        self.stress, self.law = np.zeros((2, len(self.points), 3, 3))

    def step(self, until=None):
        """A step of the simulation, then of the cells. Raises ValueError when a particle has left."""
        self.simulation.step(until)
        store, layout = self.simulation.solver.particles, self.simulation.solver.particles.layout
        table, identity = store.table(), store.labels()[:, 1]
        for k, number in enumerate(self.numbers):
            row = np.flatnonzero(identity == number)
            if not len(row):
                raise ValueError(f"particle {number} has left")
            C = table[row[0], layout.columns("affine")].astype(float).reshape(2, 2)
            self.deformation[k] += self.simulation.dt * C @ self.deformation[k]
            J = float(np.linalg.det(self.deformation[k]))
            self.stress[k] = self.points[k].deform(self.deformation[k])
            there = table[row[0], layout.columns("stress")]
            self.law[k] = unpack(there.astype(float))[np.ix_(STORE, STORE)] / J
            if self.acting:
                table[row[0], layout.columns("stress")] = pack(J * self.stress[k][np.ix_(STORE, STORE)], 2)
        if self.acting:
            store.overwrite(table)

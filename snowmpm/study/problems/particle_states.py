"""Particles of a solver by their number: what a verification case sets, adds and reads."""

import numpy as np


class ParticleStates:
    """Columns of the particles of a solver in the order of their numbers, whatever the sort does to them.

    reference: positions at the start (n, dim) [m].
    """

    def __init__(self, solver):
        self.solver, self._sorts = solver, None
        self.reference = np.empty_like(solver.particles.positions())
        self.reference[self._numbers()] = solver.particles.positions()
        self.mass = self.read(solver.particles.masses())

    def _numbers(self):
        """Number of the particle in each row; it changes with a sort only."""
        if self._sorts != self.solver.particles.sorts:
            self._sorts, self._rows = self.solver.particles.sorts, self.solver.particles.labels()[:, 1]
        return self._rows

    def read(self, rows):
        """Rows as the solver keeps them -> in the order of the numbers."""
        ordered = np.empty_like(rows)
        ordered[self._numbers()] = rows
        return ordered

    def column(self, name):
        return self.read(self.solver.particles.column(name))

    def positions(self):
        return self.read(self.solver.particles.positions())

    def set(self, where=slice(None), **columns):
        """Set columns {name: (k, size)} of the particles with numbers `where`."""
        self._change(where, columns, add=False)

    def add(self, where=slice(None), **columns):
        """Add to columns {name: (k, size)} of the particles with numbers `where`.

        A velocity dt b added before a step is a body force b in it, exactly so with PIC and APIC, whose grid sums the
        momentum m dt b; with FLIP a particle keeps its own dt b in place of the one that the grid has smoothed.
        """
        self._change(where, columns, add=True)

    def drive(self, motion, scheme, steps, dt):
        """Take steps under the body force of a manufactured motion, from its velocity half a step before the start."""
        X = self.reference
        self.set(velocity=motion.velocity(X, -0.5 * dt))
        if scheme.affine:
            self.set(affine=motion.gradient(X, -0.5 * dt))
        for _ in range(steps):
            self.add(velocity=dt * motion.body_force(X, self.solver.time))
            self.solver.step(dt)

    def _change(self, where, columns, add):
        table, numbers = self.solver.particles.table(), self._numbers()
        row_of = np.empty(len(numbers), np.int64)
        row_of[numbers] = np.arange(len(numbers))
        rows = row_of[where]
        for name, values in columns.items():
            at = self.solver.particles.layout.columns(name)
            values = np.reshape(values, (len(rows), -1))
            table[rows, at] = table[rows, at] + values if add else values
        self.solver.particles.overwrite(table)

"""A wall of rubber as a program of its own, the participant Solid of docs/precice_wall.xml:

    python docs/precice_wall.py docs/precice_wall.xml

Another structural code goes in place of `Wall`.
"""

import sys

import numpy as np

from snowmpm.components.structures.rod import Rod
from snowmpm.components.structures.section import Section


class Wall:
    """A plate clamped at its foot, in the plane of x and z, per metre of width."""

    def __init__(self, foot=(0.305, 0.0), top=(0.305, 0.1), width=0.01, modulus=1.0e6, density=1100.0, segments=6,
                 damping=0.01):
        self.rod = Rod((foot[0], 0.0, foot[1]), (top[0], 0.0, top[1]), segments,
                       Section.plate(width, modulus, density), damping)
        self.start, self.received = self.rod.x.copy(), np.zeros(2)
        """nodes at the start [m]; impulse so far [N s/m]"""

    def window(self, dt, force):
        """Displacement [m] and velocity [m/s] of the nodes (n, 2) after dt [s] under forces (n, 2) [N/m] and weight."""
        forces = self.rod.masses[:, None] * np.array([0.0, 0.0, -9.81])
        forces[:, [0, 2]] += force
        self.rod.advance(dt, forces)
        self.received = self.received + dt * force.sum(axis=0)
        return (self.rod.x - self.start)[:, [0, 2]], self.rod.v[:, [0, 2]].copy()

    def state(self):
        """What a window begins with."""
        return self.rod.state(), self.received

    def restore(self, state):
        """Take it over."""
        self.rod.restore(state[0])
        self.received = state[1]


def take_part(wall, file, steps=1, names=("Displacement",)):
    """Compute a wall until the coupling of a configuration ends; steps: in each time window; names: of its data, of
    displacements and then of velocities."""
    import precice

    mesh = "Solid-Mesh"
    solid = precice.Participant("Solid", str(file), 0, 1)
    ids = solid.set_mesh_vertices(mesh, wall.start[:, [0, 2]])
    if solid.requires_initial_data():
        for name in names:
            solid.write_data(mesh, name, ids, np.zeros((len(ids), 2)))
    solid.initialize()
    window, kept = solid.get_max_time_step_size(), None
    while solid.is_coupling_ongoing():
        if solid.requires_writing_checkpoint():
            kept = wall.state()
        left = solid.get_max_time_step_size()
        if solid.is_time_window_complete():
            window = left
        dt = min(left, window / steps)
        force = solid.read_data(mesh, "Force", ids, dt)
        for name, values in zip(names, wall.window(dt, force), strict=False):
            solid.write_data(mesh, name, ids, values)
        solid.advance(dt)
        if solid.requires_reading_checkpoint():
            wall.restore(kept)
    solid.finalize()


if __name__ == "__main__":
    take_part(Wall(), sys.argv[1])

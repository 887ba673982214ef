"""What snow and another program give each other at the ends of time windows, by preCICE.

The snow takes steps of its own within a window of length D, and writes the mean forces of the window at its end
(`external`). It reads displacements u of the nodes, and velocities v where the configuration has them. In explicit
coupling the answer for the end of a window comes after it, and the snow meets the nodes as they would go on:

    x(t) = x_0 + u_n + (t - t_n) v_n,      v_n = (u_n - u_n-1) / D  where none are given

In implicit coupling, and to the second of two programs that take turns, the answer is known ahead:

    x(t) = x_n + (t - t_n) w,      w = (x_0 + u_n+1 - x_n) / D,      v = w  where none are given

preCICE: G. Chourdakis et al. (2022), doi:10.12688/openreseurope.14445.2.
"""

import contextlib
import importlib

import numpy as np

from snowmpm.errors import InputError, SimulationError, shown_line
from snowmpm.stages import stage

LIBRARY = "precice"
"""Module of the Python bindings."""


def library(key, source):
    """The Python bindings of preCICE. InputError: they are not installed, or do not find the library."""
    try:
        module = importlib.import_module(LIBRARY)
        module.Participant  # noqa: B018  a folder of this name in the working folder is a module, too
        return module
    except (AttributeError, ImportError, RuntimeError) as error:  # the last where its MPI is missing
        raise InputError(f"{source}: {key}: needs preCICE 3 with its Python bindings ({shown_line(error, 200)})\n"
                         "install the library (precice.org/installation-overview.html), then: pip install pyprecice"
                         ) from None


class Exchange:
    """The participant of a run.

    windows: `precice_file.Windows`; open: whether the other program is met, and the coupling goes on; met: whether it
    ever was; end [s]: of the window that is computed now; where each step is one, the latest that it may have.
    """

    def __init__(self, module, windows, partners, dim):
        """module: of `library`; partners: [(`External`, table of its names, `.tables.Precice`)], of one
        participant; dim: of the scene."""
        self._module, self.windows, self._partners = module, windows, partners
        self._axes = [0, 2] if dim == 2 else [0, 1, 2]
        self.open, self.met, self.end = False, False, np.inf

    def connect(self, path, time):
        """Meet the other program, which may take until it is started, at `time` [s]; path: of the configuration."""
        with stage("waiting for the other program of preCICE"), _failures("at the start"):
            name = self._partners[0][1].participant
            self._participant = participant = self._module.Participant(name, str(path), 0, 1)
            self._meshes = []
            for external, names in self._partners:
                dim = participant.get_mesh_dimensions(names.mesh)
                columns = [0, 1] if dim == 2 else self._axes
                start = np.zeros((external.n + 1, dim))
                start[:, columns] = external.start[:, self._axes]
                ids = np.asarray(participant.set_mesh_vertices(names.mesh, start))
                participant.set_mesh_edges(names.mesh, ids[external.ends])
                self._meshes.append((external, names, ids, columns, dim))
            if participant.requires_initial_data():
                self._write()
            participant.initialize()
            self.open = self.met = True
            for external, names, *mesh in self._meshes:
                velocity = self._read(names, "velocity", mesh, 0.0)
                external.place(self._read(names, "displacement", mesh, 0.0), 0.0 if velocity is None else velocity)
        self.begin(time)

    def begin(self, time):
        """A window begins at `time` [s], for the first time or again."""
        with _failures(f"at t = {time:.6g} s"):
            self._participant.requires_writing_checkpoint()  # the state is kept wherever windows are repeated
            self._size = self._participant.get_max_time_step_size()
            self.end = time + self._size
            if self.windows.ahead:
                for external, names, *mesh in self._meshes:
                    external.head_for(self._read(names, "displacement", mesh, self._size), self._size,
                                      self._read(names, "velocity", mesh, self._size))

    def finish(self, time, dt):
        """End a window at `time` [s] with a step of dt [s]; -> whether it has to be computed again."""
        size = dt if self.windows.size is None else self._size
        with _failures(f"at t = {time:.6g} s"):
            for external, *_ in self._partners:
                external.hand_over(size)
            self._write()
            self._participant.advance(size)
            if self._participant.requires_reading_checkpoint():
                return True
            if not self.windows.ahead:
                for external, names, *mesh in self._meshes:
                    external.take_displacement(self._read(names, "displacement", mesh, 0.0), size,
                                    self._read(names, "velocity", mesh, 0.0))
            if not self._participant.is_coupling_ongoing():
                self._participant.finalize()
                self.open = False
        return False

    def _write(self):
        for external, names, ids, columns, dim in self._meshes:
            values = np.zeros((len(ids), dim))
            values[:, columns] = external.force[:, self._axes]
            self._participant.write_data(names.mesh, names.force, ids, values)

    def _read(self, names, key, mesh, ahead):
        """Vectors (nodes, 3) of the data that the scene's `key` names, so long after the begin of the window [s]; None
        where it names none."""
        name, (ids, columns, _) = names[key], mesh
        if name is None:
            return None
        found = np.zeros((len(ids), 3))
        found[:, self._axes] = self._participant.read_data(names.mesh, name, ids, ahead)[:, columns]
        return found


@contextlib.contextmanager
def _failures(when):
    """Context: turns errors of the library into a SimulationError that says when."""
    try:
        yield
    except RuntimeError as error:
        raise SimulationError(f"preCICE, {when}: {shown_line(error, 300)}") from error

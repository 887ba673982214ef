"""A stand-in for the module `precice` (version 3) whose other participant computes in the same process.

It keeps the rules that preCICE enforces: names of the configuration, steps no longer than allowed, data set on known
vertices, reading times within the window, checkpoints asked for before `advance`. Serial schemes in which snowmpm is
the first of two.
"""

import numpy as np

FREE = 1e30
"""Longest step where the first participant sets the windows, and the coupling never ends."""


class StandIn:
    """The module. `Participant(name, file, 0, 1)` is the only one there can be.

    peer: computes windows, `peer.window(dt, force) -> displacement, velocity` (n, dim), `peer.state()` and
    `peer.restore(state)`; size [s]: of windows, None: the steps of the snow; end [s]: of the coupling; rounds: of an
    implicit window at most, 0 in explicit coupling; tolerance: relative change at which it ends.
    """

    def __init__(self, peer, end, size=None, rounds=0, tolerance=1e-8, dim=2):
        self.peer, self.end, self.size, self.rounds, self.tolerance, self.dim = peer, end, size, rounds, tolerance, dim
        self.participants, self.passed = [], []
        """those made; (force, window) of all windows that were accepted"""

    def Participant(self, name, file, rank, ranks):
        """As `precice.Participant`."""
        assert name == "Snow" and file.endswith(".xml") and (rank, ranks) == (0, 1)
        self.participants.append(_Participant(self))
        return self.participants[-1]


class _Participant:
    def __init__(self, world):
        self._world, self.time, self.left, self._begun = world, 0.0, 0.0, False
        self.finalized, self._ids, self._force = False, None, None
        self._write_first = self._read_first = False

    # ---- mesh -------------------------------------------------------------------------------------------------

    def get_mesh_dimensions(self, mesh):
        assert mesh == "Snow-Mesh"
        return self._world.dim

    def set_mesh_vertices(self, mesh, positions):
        assert not self._begun and positions.shape[1] == self.get_mesh_dimensions(mesh)
        self.positions, self._ids = positions.copy(), np.arange(len(positions), dtype=np.int32)
        return self._ids

    def set_mesh_edges(self, mesh, edges):
        assert np.isin(edges, self._ids).all() and edges.shape[1] == 2

    # ---- steps ------------------------------------------------------------------------------------------------

    def requires_initial_data(self):
        return False

    def initialize(self):
        assert not self._begun
        self._begun = True
        self._now = self._ahead = (np.zeros_like(self.positions),) * 2
        self._window()

    def _window(self):
        world = self._world
        self._left = min(world.size or FREE, world.end - self.time)
        self._round, self._write_first = 0, world.rounds > 0
        self._kept = world.peer.state() if world.rounds else None

    def get_max_time_step_size(self):
        assert self._begun and not self.finalized
        return self._left

    def requires_writing_checkpoint(self):
        asked, self._write_first = self._write_first, False
        return asked

    def requires_reading_checkpoint(self):
        asked, self._read_first = self._read_first, False
        return asked

    def is_coupling_ongoing(self):
        return self.time < self._world.end - 1e-14

    def advance(self, dt):
        world = self._world
        assert not (self._write_first or self._read_first), "a checkpoint was not asked for"
        assert 0.0 < dt <= self._left * (1.0 + 1e-14) and self.is_coupling_ongoing()
        assert world.size is None or dt == self._left, "the tests hand over once a window"
        answer = world.peer.window(dt, self._force.copy())
        self._round += 1
        change = max(np.linalg.norm(new - old) / max(np.linalg.norm(new), 1e-30)
                     for new, old in zip(answer, self._ahead, strict=True))
        if world.rounds and change > world.tolerance and self._round < world.rounds:
            # Half of the way: enough for a peer as heavy as the snow that it meets
            self._ahead = tuple(0.5 * (new + old) for new, old in zip(answer, self._ahead, strict=True))
            world.peer.restore(self._kept)
            self._read_first = True
            return
        world.passed.append((self._force.copy(), dt))
        self.time += dt
        self._now = self._ahead = answer
        if self.is_coupling_ongoing():
            self._window()

    def finalize(self):
        assert not self.finalized
        self.finalized = True

    # ---- data -------------------------------------------------------------------------------------------------

    def write_data(self, mesh, name, ids, values):
        assert (mesh, name) == ("Snow-Mesh", "Force") and np.array_equal(ids, self._ids)
        assert values.shape == self.positions.shape
        self._force = np.array(values)

    def read_data(self, mesh, name, ids, ahead):
        assert mesh == "Snow-Mesh" and np.array_equal(ids, self._ids)
        assert ahead == 0.0 if not self.is_coupling_ongoing() else 0.0 <= ahead <= self._left
        which = ("Displacement", "Velocity").index(name)
        share = ahead / self._left if self._world.rounds and ahead else 0.0
        return (1.0 - share) * self._now[which] + share * self._ahead[which]

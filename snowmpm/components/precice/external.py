"""A polyline of nodes that another program moves: what `rods.Rods` asks of a rod, without mechanics of its own.

In a time window from t_n, of length D, the nodes are in the snow with velocities v and places

    x(t) = x_n + (t - t_n) w

and what the snow gives them adds up to the impulse J of the window. What is handed over is the mean force J / D, so
that the other program receives the momentum that the snow lost. v and w come from what it answers (`exchange`).
"""

import numpy as np


class External:
    """State of such a structure.

    x, v (nodes, 3): places [m] and velocities [m/s] at which the snow meets the nodes; drift (nodes, 3) [m/s]: w;
    start (nodes, 3) [m]: x at time zero; answered (nodes, 3) [m]: displacement read last; impulse (nodes, 3) [N s]: of
    the snow in this window; force (nodes, 3) [N]: mean of the window before; given (3,) [N s]: all that was handed
    over. ends (n, 2): nodes of each segment; along (n, 3), lengths (n,) [m]: of the segments at the start. In 2-D they
    lie in the plane y = 0, and forces are per metre of width.
    """

    met = None
    energy = 0.0
    """its own energy [J], which the other program knows"""

    def __init__(self, points, segments):
        """points (k, 3) [m]: corners of the polyline; segments: pieces of each stretch between two."""
        points = np.asarray(points, float)
        at = np.linspace(0.0, len(points) - 1.0, segments * (len(points) - 1) + 1)
        self.start = np.column_stack([np.interp(at, np.arange(len(points)), column) for column in points.T])
        self.n = len(self.start) - 1
        self.ends = np.column_stack([np.arange(self.n), np.arange(1, self.n + 1)])
        edges = np.diff(self.start, axis=0)
        self.lengths = np.linalg.norm(edges, axis=1)
        self.along = edges / self.lengths[:, None]
        self.masses = np.zeros(self.n + 1)
        self.x, self.v, self.drift, self.answered, self.impulse, self.force = (
            np.zeros_like(self.start) for _ in range(6))
        self.given = np.zeros(3)
        self.begin()

    def begin(self):
        """At rest where it was drawn; nothing was handed over."""
        self.x[:] = self.start
        for values in (self.v, self.drift, self.answered, self.impulse, self.force, self.given):
            values[:] = 0.0

    def advance(self, dt, forces):
        """A step of dt [s] in which the snow gave the nodes forces (nodes, 3) [N]."""
        self.impulse += dt * forces
        self.x += dt * self.drift

    def hand_over(self, window):
        """A window of this length [s] ends, in which the mean force was J / D."""
        self.force[:] = self.impulse / window
        self.given += window * self.force.sum(axis=0)
        self.impulse[:] = 0.0

    def place(self, displacement, velocity):
        """Be at a displacement (nodes, 3) [m] from the start, and go on with velocity (nodes, 3) [m/s] from there."""
        self.answered[:] = displacement
        self.x[:] = self.start + displacement
        self.v[:] = self.drift[:] = velocity

    def take_displacement(self, displacement, window, velocity=None):
        """`place` after a window of this length [s]; velocity: that from the last answer to this one when missing."""
        self.place(displacement, (displacement - self.answered) / window if velocity is None else velocity)

    def head_for(self, displacement, window, velocity=None):
        """Come to a displacement (nodes, 3) [m] at the end of a window of this length [s]; velocity (nodes, 3) [m/s]:
        with which the snow meets the nodes, that of this way when missing."""
        self.drift[:] = (self.start + displacement - self.x) / window
        self.v[:] = self.drift if velocity is None else velocity

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    def held(self):
        """Impulse (3,) [N s] that the snow gave and that left: handed over, or waiting for the end of the window."""
        return -self.given - self.impulse.sum(axis=0)

    def numbers(self, dim):
        """Numbers of the history, by what follows its name: (value, unit). Displacement of the last node, force of the
        snow that was handed over last."""
        axes, where = ("xz", [0, 2]) if dim == 2 else ("xyz", [0, 1, 2])
        unit, force = "N/m" if dim == 2 else "N", self.force.sum(axis=0)
        return {**{f"top_{axis}": (float(self.x[-1, a] - self.start[-1, a]), "m")
                   for axis, a in zip(axes, where, strict=True)},
                **{f"force_{axis}": (float(force[a]), unit) for axis, a in zip(axes, where, strict=True)}}

    PARTS = ("x", "v", "drift", "answered", "impulse", "force", "given")

    def state(self):
        """All that a continuation within the run needs, by name."""
        return {name: vars(self)[name].copy() for name in self.PARTS}

    def restore(self, state):
        """Take over what `state()` gave."""
        for name in self.PARTS:
            vars(self)[name][:] = state[name]

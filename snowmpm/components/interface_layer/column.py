"""Points of an interface: a layer of snow without cells of its own, between rigid ground and the snow above.

A layer of thickness t is much thinner than a cell. A point on its upper face carries the area A and stands for the
column of the layer below, whose lower face rests on the ground. The snow above moves the point by u, so that the layer
is deformed as a whole,

    F = I + u N^T / t,   J = det F = 1 + u.N / t,   L = F' F^-1 = v b^T / J,   b = N / t

with N the normal of the ground: closing and opening along N, sliding across it, and no strain along the layer. The law
of its material gives the Kirchhoff stress tau of that, whichever law it is. The power of the stress, V tau : L with the
volume V = A t, is that of the traction p = tau b / J on the snow above,

    f_i = -V tau b / J (w_ip - h N.g_ip)

where w_ip is the spline and g_ip what the scheme takes for its gradient. The point lies h, half a particle spacing,
above the face, among the lowest particles of the snow, and takes the velocity v = v_p - h (grad v) N of the face from
there: on the face itself it would reach nodes that hardly any snow moves, and these, not the snow, would carry the
traction (a slab of two cells sank by 4 mm in 0.2 s). Stiffness E' / t and G / t, strength, softening, collapse and
friction are those of the card, energies per area t times its energies per volume, on any grid.

The strain of a thin layer as its displacement over its thickness, with a law of the bulk: Schellekens & de Borst
(1993), doi:10.1002/nme.1620360904.

The column of a point holds b (dim numbers [1/m]), u (dim numbers [m]), whether a saw has cut it, which leaves no
stress, and h [m]; of other particles it is zero. A point becomes an ordinary particle (b = 0) once nothing of the layer
is left: it has slid or opened by `SLIDES` thicknesses and at least a cell, or is closed to `CLOSED` of its thickness.

The ground does not touch the snow above an interface: nodes that a point reaches take no part in the contact with it
(`.hidden_nodes`).
"""

import functools
from types import SimpleNamespace

import numpy as np

from snowmpm.compiler import ti

COLUMN = "interface"
CUT = 2
"""Place of the mark of a cut in the column, in units of dim."""


def lift_at(dim):
    """Place of h in the column."""
    return CUT * dim + 1


SLIDES = 2.0
"""Thicknesses of the layer that the snow above slides, or opens, until nothing of the layer is left."""

CLOSED = 0.05
"""Share of the thickness that is left when the snow above lies on the ground."""


def size(dim):
    """Numbers of the column."""
    return 2 * dim + 2


def stiffest(population, laws, dim):
    """Largest c / t [1/s] of the points of a `Population`, but for the factor of `swing`."""
    rate = np.linalg.norm(population.columns[COLUMN][:, :dim], axis=1)
    speed = np.array([law.fastest_wave() for law in laws])[population.material]
    return float((rate * speed).max(initial=0.0))


def swing(lift, inverse_second_moment):
    """Frequency over c / t above which no point can swing by its own mass alone, since traction and inertia go by the
    same weights: sqrt(sum w (1 - h N.g / w)^2) = sqrt(1 + h^2 / D). lift: h [cells]."""
    return float(np.sqrt(1.0 + lift**2 * inverse_second_moment))


@functools.cache
def point_functions(dim, real):
    """Taichi functions of a point, of its column's vectors b, u and the mark `cut`."""

    @ti.func
    def stands(b):
        """1 for a point of an interface, 0 for an ordinary particle."""
        return ti.select(b.norm_sqr() > 0.0, ti.cast(1.0, real), ti.cast(0.0, real))

    @ti.func
    def normal(b):
        return b / ti.max(b.norm(), 1e-30)

    @ti.func
    def face_velocity(L, v, b, lift):
        """Velocity of the upper face of the layer, of that of the point and its gradient L."""
        return v - lift * (L @ normal(b))

    @ti.func
    def gradient(L, v, b, cut, ratio):
        """Velocity gradient of the layer, of the velocity v of its face; L: of an ordinary particle."""
        held = stands(b)
        return (1.0 - held) * L + (held * (1.0 - cut) / ti.max(ratio, CLOSED)) * v.outer_product(b)

    @ti.func
    def left(b, u, dx):
        """b after the displacement u: 0 once nothing is left of the layer."""
        rate2 = b.norm_sqr()
        reach = ti.max(dx * dx, ti.static(SLIDES**2) / ti.max(rate2, 1e-30))
        gone = (u.norm_sqr() > reach) | (1.0 + u.dot(b) < CLOSED)
        return ti.select(gone, 0.0, 1.0) * b

    return SimpleNamespace(stands=stands, normal=normal, face_velocity=face_velocity, gradient=gradient, left=left)

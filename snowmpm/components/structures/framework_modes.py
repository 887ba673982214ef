"""Small vibrations of a framework about its start: frequencies, and whether it is a structure at all."""

import numpy as np

NOTHING = 1e-12
"""Square of a frequency over that of the highest one below which nothing resists."""

TURNING = 1e-6
"""Share of the kinetic energy of a mode in places below which it is a member that turns about its own axis."""


class Modes:
    """squares (k,) [1/s2]: of angular frequencies, from the lowest; shapes (p, k, 3): of the places, each mode of unit
    kinetic energy 1/2; those where nothing but turns about axes of members moves are left out."""

    def __init__(self, mesh, stiffness, plane):
        """mesh: `FrameworkMesh`; stiffness (n, 12, 12) of its elements; plane: whether nothing leaves y = const."""
        p, t = len(mesh.places), len(mesh.clamped)
        inertias = mesh.inertias(mesh.links)
        keep = np.ones((p + t, 3), bool)
        keep[:p][mesh.held] = False
        keep[p:][mesh.clamped | (np.trace(inertias, axis1=1, axis2=2) == 0.0)] = False
        if plane:
            keep[:p, 1], keep[p:, [0, 2]] = False, False
        own = np.flatnonzero(keep.ravel())
        K, M = np.zeros((2, 3 * (p + t), 3 * (p + t)))
        rows = 3 * np.column_stack([mesh.links[:, :2], p + mesh.links[:, 2:]])[:, :, None] + np.arange(3)
        for row, k in zip(rows.reshape(-1, 12), stiffness, strict=True):
            K[np.ix_(row, row)] += k
        np.einsum("ii->i", M)[: 3 * p] = np.repeat(mesh.masses, 3)
        for i, J in enumerate(inertias):
            M[3 * (p + i) : 3 * (p + i) + 3, 3 * (p + i) : 3 * (p + i) + 3] = J
        from scipy.linalg import eigh  # slow to import

        squares, vectors = eigh(K[np.ix_(own, own)], M[np.ix_(own, own)])
        whole = np.zeros((3 * (p + t), len(own)))
        whole[own] = vectors
        shapes = whole[: 3 * p].reshape(p, 3, -1).transpose(0, 2, 1)
        moves = np.einsum("p,pkc->k", mesh.masses, shapes**2) > TURNING
        self.squares, self.shapes = squares[moves], shapes[:, moves]
        self._joints = len(mesh.joints)
        self._none = self.squares < NOTHING * squares[-1] if len(squares) else np.zeros(0, bool)

    @property
    def first(self):
        """Lowest angular frequency that is none of a mechanism [rad/s]."""
        return float(np.sqrt(self.squares[~self._none].min(initial=np.inf)))

    @property
    def loose(self):
        """Number of the joint that moves most where nothing resists; None if all is held."""
        if not self._none.any():
            return None
        return int((self.shapes[: self._joints, self._none] ** 2).sum(axis=(1, 2)).argmax())


def element_stiffness(triad, length, axial, twist, bend):
    """K (12, 12) of an element for small movements: of its first and last place and its first and last turn.

        energy = E A u^2 / 2 l + G J t^2 / 2 l + 2 E I / l (a^2 + a b + b^2)  of stretch, twist, and turns of both ends
    """
    e1, e2, e3 = triad
    B, along, first, last = np.zeros((6, 12)), slice(0, 3), slice(6, 9), slice(9, 12)
    B[0, 3:6] = e1
    B[1, last], B[1, first] = e1, -e1
    for end, own in ((0, first), (1, last)):
        B[2 + end, own], B[2 + end, 3:6] = e2, e3 / length
        B[4 + end, own], B[4 + end, 3:6] = e3, -e2 / length
    B[:, along] = -B[:, 3:6]
    D = np.diag([axial, twist, 0.0, 0.0, 0.0, 0.0]) / length
    D[2:4, 2:4] = D[4:6, 4:6] = bend / length * np.array([[4.0, 2.0], [2.0, 4.0]])
    return B.T @ D @ B

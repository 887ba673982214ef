"""Forces on parts of the surface of bodies among the equations of a step.

A point that particle p carries at an arm r goes by sum_I N_I u_I, N_I = w_I + g_I . r, and its area becomes
det f  f^-T a with the deformation f = I + A of p. On node I acts N_I F, F at the end of the step, and K gets
-d(N_I F) / du_K:

    springs       N_I k A P N_K
    pressure      p N_I (a_i t_kl - a_k t_il) g_Kl,    t = f^-T,  a now

The second one is the load stiffness of a pressure that follows, which is not symmetric where the loaded surface has an
edge; the linear solver looks whether K is. A pressure that depends on place is that of the start of a step.
"""

import numpy as np
from scipy import sparse

from snowmpm.annotations import derived
from snowmpm.components.face_loads.faces import OfFaces
from snowmpm.components.face_loads.from_scene import faces_of
from snowmpm.implicit.kernel_api import Term, turned


def adapter(model):
    """`FaceLoads` of the scene of a `Model`."""
    return FaceLoads(faces_of(model))


class FaceLoads(OfFaces):
    """The `Faces` of an `ImplicitSolver`."""

    def terms(self, matter, time):
        """`FaceTerm` of a step."""
        return FaceTerm(self.faces, matter, time)


class FaceTerm(Term):
    """The `Faces` of a step that ends at `time` [s], for the particles of a `MaterialPoints`."""

    def __init__(self, faces, matter, time):
        self.faces, points = faces, faces.points
        row_of = np.full(max(matter.number.max(initial=0), points.number.max()) + 1, -1)
        row_of[matter.number] = np.arange(len(matter.number))
        self._rows = row_of[points.number]
        self._acting = []
        there = self._rows >= 0
        self._rows = np.maximum(self._rows, 0)
        for face in faces.faces:
            if face.acts(time):
                values = face.prescribed(faces.at(face), time)
                self._acting.append((face, values, there[face.points]))

    @derived
    def force(self):
        """Of the last step (dim,) [N]."""
        return self.faces.force

    def meet(self, mesh):
        """Take a `Mesh` of the particles as they are now."""
        self._mesh, arms = mesh, self.faces.points.arm
        self._G = [sparse.csr_array(G[self._rows]) for G in mesh.G]
        self._N = sparse.csr_array(mesh.W[self._rows]) + sum(
            sparse.diags_array(arms[:, a]) @ G for a, G in enumerate(self._G))

    def at(self, u):
        """Forces on the nodes (N, dim) [N] at displacements u (N, dim) [m]."""
        return self._N.T @ self._forces(u)

    def _forces(self, u):
        """F (n, dim) [N] on the points."""
        points, found = self.faces.points, np.zeros_like(self.faces.points.way)
        area = points.areas_after(self._deformed(u))
        way = points.way + self._N @ u
        for face, values, there in self._acting:
            own = face.points
            forces = face.forces(self.faces.at(face), area[own], way[own], values)
            found[own] = np.where(there[:, None], forces, 0.0)
        return found

    def _deformed(self, u):
        """A (n, dim, dim) of the particles that carry points."""
        return np.stack([G @ u for G in self._G], axis=2)

    def matrix(self, u):
        """-d at(u) / du, (dim N, dim N)."""
        points, A = self.faces.points, self._deformed(u)
        n, dim = points.way.shape
        way, area, growth = points.way + self._N @ u, points.areas_after(A), np.linalg.det(A + np.eye(dim))
        pressing, springs = np.zeros((n, dim)), np.zeros((n, dim, dim))
        for face, values, there in self._acting:
            own = face.points
            pressing[own] = np.where(there, face.pressure(values), 0.0)[:, None] * area[own]
            springs[own] = there[:, None, None] * face.springs(self.faces.at(face), way[own], values)
        turn, blocks = turned(A, growth), [[None] * dim for _ in range(dim)]
        for i in range(dim):
            for k in range(dim):
                along = pressing[:, i, None] * turn[:, k] - pressing[:, k, None] * turn[:, i]
                acting = sparse.diags_array(springs[:, i, k]) @ self._N
                acting = acting + sum(sparse.diags_array(along[:, a]) @ G for a, G in enumerate(self._G))
                blocks[i][k] = self._N.T @ acting
        order = np.arange(dim * self._mesh.n_nodes).reshape(dim, -1).T.ravel()  # by nodes, not by components
        return sparse.csr_array(sparse.block_array(blocks, format="csr"))[order][:, order]

    def carry(self, u, early, late):
        """Move the points by u (N, dim) [m], and count what the forces did, those before it for the time `early` [s],
        those at its end for `late` [s]; -> impulse (dim,) [N s]."""
        points, forces, way = self.faces.points, self._forces(u), self._N @ u
        impulse = self.faces.close(forces, early, late, way)
        points.move_with(self._deformed(u), way)
        return impulse

"""One change of volume for all particles of a cell (F-bar), against volumetric locking.

A quadratic spline has about one node a cell, with dim components, but four or eight particles: where each of them must
keep its volume, hardly any motion is left. Here the volume of a cell changes as a whole:

    f_bar = (j_bar / j)^(1/dim) f,    j_bar = sum_p w_p j_p / sum_p w_p

over the particles of a cell between the knots of the spline; f = I + A, j = det f, w_p: volume at the start of the
step. The laws see f_bar. Forces follow from the same energy, so that they are its derivative, and elasticity stays
symmetric: with pi = tr(tau) / dim over the axes of the scene and S = sum_p V pi of the cell,

    V P = V (tau - pi I) f^-T + S omega f^-T,    omega_p = w_p j_p / sum_q w_q j_q

de Souza Neto et al. 1996, doi:10.1016/0020-7683(95)00259-6 (F-bar); Elguedj et al. 2008,
doi:10.1016/j.cma.2008.01.012 (from an energy, for splines); Coombs et al. 2018, doi:10.1016/j.cma.2018.01.010 (means
over the particles of a cell).

The matrix has, beside the tangent of each particle, products of rows of a cell, y = b . u its change of ln j_bar:

    K = sum_p V g . C . g + sum_c (r b^T + b h^T + (k - S) b b^T)
"""

import numpy as np
from scipy import sparse

from snowmpm.implicit.kernel_api import Strain
from snowmpm.stepping.component import Adapter


def adapter(model):
    """`CellVolumes`."""
    return CellVolumes()


class CellVolumes(Adapter):
    """One change of volume for the particles of each cell of an `ImplicitSolver`."""

    name = "f_bar"

    def strain(self, mesh, matter):
        """`CellStrain` of a step."""
        return CellStrain(mesh, matter.volume, matter.ratio)


class CellStrain(Strain):
    """Means over the cells of a `Mesh`. volume (n,): V [m3], at the reference; ratio (n,): J at the start."""

    def __init__(self, mesh, volume, ratio):
        self._mesh, self._volume, self._now = mesh, volume, volume * ratio
        self._n_cells = len(mesh.cell_nodes)
        self._whole = 1.0 / self._sums(self._now)

    def _sums(self, values):
        """Sum over the particles of each cell, of values (n,)."""
        return np.bincount(self._mesh.cell_of, values, minlength=self._n_cells)

    def seen(self, A):
        """A_bar (n, dim, dim), f_bar less I, and whether no particle is turned inside out."""
        dim, grown = A.shape[1], growth(A)
        if not (grown > -1.0).all():
            return A, False
        mean = (self._sums(self._now * grown) * self._whole)[self._mesh.cell_of]
        more = np.expm1((np.log1p(mean) - np.log1p(grown)) / dim)[:, None, None]
        return A + more * (A + np.eye(dim)), True

    def forces(self, A, after):
        """P (n, dim, dim) [Pa] of the forces on the nodes. A (n, dim, dim): of the nodes; after: `After` of A_bar."""
        return _Step(self, A, after).forces()

    def matrix(self, A, after):
        """V C of each particle (n, dim, dim, dim, dim) [J], and the rest of K, of the cells, sparse (dim N, dim N).
        after: of A_bar, with tangents."""
        step = _Step(self, A, after)
        return step.local(), step.shared()


def growth(A):
    """det(I + A) - 1 (n,) of A (n, dim, dim): to round-off of A, not of 1, since nearly incompressible laws see it."""
    trace, dim = np.einsum("nii->n", A), A.shape[1]
    second = 0.5 * (trace**2 - np.einsum("nij,nji->n", A, A))
    return trace + second + (np.linalg.det(A) if dim == 3 else 0.0)


class _Step:
    """What a step makes of the cells. A: of the nodes; after: `After` of A_bar, as the laws gave it."""

    def __init__(self, cells, A, after):
        dim = A.shape[1]
        self.cells, self.dim, self.P, self.C = cells, dim, after.P, after.C
        f = A + np.eye(dim)
        own = cells._now * np.linalg.det(f)
        whole, cell = cells._sums(own), cells._mesh.cell_of
        self.share = own / whole[cell]
        self.stretch = ((whole * cells._whole)[cell] * cells._now / own) ** (1.0 / dim)
        self.f, self.turn = f, np.swapaxes(np.linalg.inv(f), 1, 2)
        self.f_bar = self.stretch[:, None, None] * f
        self.mean = np.einsum("nij,nij->n", self.P, self.f_bar) / dim
        self.pull = cells._sums(cells._volume * self.mean)
        """S of the cells [J]"""
        self.given = self.pull[cell] * self.share
        """S omega of the particles [J]"""

    def forces(self):
        """P (n, dim, dim)."""
        more = self.given / self.cells._volume - self.mean
        return self.stretch[:, None, None] * self.P + more[:, None, None] * self.turn

    def _bent(self):
        """Derivatives by f_bar: C : f_bar / dim (n, dim, dim), of pi times dim, B (n, dim, dim), and B : f_bar."""
        along = np.einsum("nijkl,nkl->nij", self.C, self.f_bar) / self.dim
        B = np.einsum("nij,nijkl->nkl", self.f_bar, self.C) + self.P
        return along, B, np.einsum("nij,nij->n", B, self.f_bar)

    def _of_mean(self, B, twice):
        """d pi / dA (n, dim, dim) at a constant j_bar."""
        return (self.stretch[:, None, None] * B - (twice / self.dim)[:, None, None] * self.turn) / self.dim

    def local(self):
        s, t, dim = self.stretch[:, None, None], self.turn, self.dim
        along, B, twice = self._bent()
        C = s[..., None, None] * (s[..., None, None] * self.C)
        C -= np.einsum("nij,nkl->nijkl", s * along + s * self.P / dim, t)
        C -= np.einsum("nij,nkl->nijkl", t, self._of_mean(B, twice))
        swapped, volume = np.einsum("nil,nkj->nijkl", t, t), self.cells._volume[:, None, None, None, None]
        C = volume * (C + self.mean[:, None, None, None, None] * swapped)
        return C + self.given[:, None, None, None, None] * (np.einsum("nij,nkl->nijkl", t, t) - swapped)

    def shared(self):
        volume, s = self.cells._volume[:, None, None], self.stretch[:, None, None]
        along, B, twice = self._bent()
        b = self._rows(self.share[:, None, None] * self.turn)
        h = self._rows(volume * self._of_mean(B, twice))
        r = self._rows(volume * (s * self.P / self.dim + s * along - (twice / self.dim**2)[:, None, None] * self.turn))
        own = self.cells._sums(self.cells._volume * twice) / self.dim**2 - self.pull
        return r.T @ b + b.T @ (h + sparse.dia_array((own[None], 0), shape=2 * (len(own),)) @ b)

    def _rows(self, X):
        """sum_p X_p . g of each cell, sparse (cells, dim N), of X (n, dim, dim)."""
        mesh = self.cells._mesh
        size = len(mesh.steps) * self.dim
        of_particles = np.einsum("nij,nsj->nsi", X, mesh.gradients).reshape(-1, size)
        n, C = len(of_particles), self.cells._n_cells
        gather = sparse.csr_array((np.ones(n), (mesh.cell_of, np.arange(n))), shape=(C, n))
        columns = (self.dim * mesh.cell_nodes[:, :, None] + np.arange(self.dim)).reshape(C, size)
        return sparse.csr_array(((gather @ of_particles).ravel(), columns.ravel(), np.arange(0, C * size + 1, size)),
                                shape=(C, self.dim * mesh.n_nodes))

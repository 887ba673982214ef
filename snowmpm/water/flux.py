"""Two-point flux through the faces of material cells: pressure, heat or vapour by one operator.

Through a face of area A between cells i and j a distance d apart, with the conductivity c of the flux -c grad u,

    Q_ij = A c_ij / d (u_i - u_j),   c_ij = 2 c_i c_j / (c_i + c_j)          (series of two half cells)

and through a border face whose value is prescribed, half a cell away, Q = 2 A c_i / d (u_i - u_face) (Nøst 2019, eqs.
7.11-7.21; Eymard, Gallouët and Herbin 2000, doi:10.1016/S1570-8659(00)07005-8). The grid is Cartesian, so two points
are consistent. The matrix is symmetric, with a positive diagonal and no positive entry beside it: implicit steps obey
the maximum principle.
"""

import numpy as np

DIRECT = 3000
"""Unknowns up to which a system is factorised; beyond, conjugate gradients."""

TOLERANCE = 1e-12
"""Of conjugate gradients, residual over right side. Budgets close whatever it is: they add up fluxes."""


def series(first, second):
    """Harmonic mean of conductivities, 0 where one is 0."""
    total = first + second
    return np.divide(2.0 * first * second, total, out=np.zeros(np.shape(total)), where=total > 0.0)


class TwoPointFlux:
    """Fluxes and matrix on `MaterialCells` of size dx [m]; in 2-D per metre of width."""

    def __init__(self, cells, dx):
        self.cells, self.dx = cells, dx
        dim = cells.coordinates.shape[1]
        self.shape_factor = dx ** (dim - 2)
        """area of a face over the distance of two centres [m], in 2-D [1]"""
        self.area = dx ** (dim - 1)

    def conductances(self, conductivity):
        """A c / d of inner faces, for c (cells,)."""
        cells = self.cells
        return self.shape_factor * series(conductivity[cells.first], conductivity[cells.second])

    def border_conductances(self, conductivity):
        """A c / (d / 2) of border faces, for c (cells,)."""
        return 2.0 * self.shape_factor * conductivity[self.cells.border]

    def outflow(self, inner, border):
        """Sum of fluxes out of each cell: inner (faces,) from first to second, border (border faces,) outward."""
        cells, n = self.cells, len(self.cells)
        return (np.bincount(cells.first, inner, n) - np.bincount(cells.second, inner, n)
                + np.bincount(cells.border, border, n))

    def matrix(self, diagonal, inner, border):
        """diag + sum of faces (sparse, n x n): inner, border: conductances of faces; diagonal (cells,)."""
        cells, n = self.cells, len(self.cells)
        total = (diagonal + np.bincount(cells.first, inner, n) + np.bincount(cells.second, inner, n)
                 + np.bincount(cells.border, border, n))
        rows = np.concatenate([np.arange(n), cells.first, cells.second])
        columns = np.concatenate([np.arange(n), cells.second, cells.first])
        from scipy.sparse import coo_matrix  # slow to import

        return coo_matrix((np.concatenate([total, -inner, -inner]), (rows, columns)), (n, n)).tocsr()


def solve(matrix, right, start=None):
    """Solution of a symmetric positive definite system. start: first guess of iterations.

    Raises ArithmeticError when conjugate gradients do not converge.
    """
    n = len(right)
    if n == 0:
        return np.zeros(0)
    from scipy.sparse import diags, linalg

    if n <= DIRECT:
        return linalg.splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(right)
    scale = 1.0 / matrix.diagonal()
    found, failed = linalg.cg(matrix, right, x0=start, rtol=TOLERANCE, maxiter=20 * n, M=diags(scale))
    if failed:
        raise ArithmeticError("conjugate gradients did not converge")
    return found


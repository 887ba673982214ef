"""The linear equations of Newton's method, by a direct solver or by iterations.

Unknowns are scaled by the square root of the matrix's diagonal: that of a node which one particle hardly reaches is
smaller than the others by as much as its weight is, and so are its forces. Nodes that nothing at all resists get a
stiffness of their own. What comes out need not be exact: Newton's residual is.
"""

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

MOST_DIRECT = {2: 120_000, 3: 15_000}
"""Unknowns up to which a scene is solved directly, by dimension."""

MOST_ITERATIONS = 2000

FAINT = 1e-12
"""Added to the scaled diagonal of 1, for nodes that only round-off holds."""


class Singular(Exception):
    """The matrix has no inverse: a mechanism, or a material that gives way."""


class Linear:
    """Solves test^T K T x = b, again and again. kind: "direct", "krylov" or "auto"; T, test: of `Held`, the same when
    missing."""

    def __init__(self, T, dim, kind="auto", test=None):
        self.T, self._dim, self._test = T, dim, T if test is None else test
        self._plain = T.shape[0] == T.shape[1] and T.nnz == T.shape[0]
        direct = T.shape[1] <= MOST_DIRECT[dim] if kind == "auto" else kind == "direct"
        self._solve = self._direct if direct else self._krylov
        self.iterations = 0
        """of all Krylov solves"""

    def solve(self, K, b, tolerance):
        """x. tolerance: |test^T K T x - b| / |b| of iterations. Raises Singular."""
        x = self._solve(K, b, tolerance)
        if not np.isfinite(x).all():
            raise Singular("the matrix has no inverse")
        return x

    def _direct(self, K, b, tolerance):
        matrix = sparse.csc_array(K if self._plain else self._test.T @ K.tocsr() @ self.T)
        scale = _scale(matrix.diagonal())
        scaled = sparse.dia_array((scale[None], 0), shape=matrix.shape)
        matrix = scaled @ matrix @ scaled + FAINT * sparse.eye_array(len(b))
        try:
            factors = linalg.splu(sparse.csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01,
                                  options={"SymmetricMode": True})
        except RuntimeError as error:
            raise Singular("the matrix has no inverse") from error
        return scale * factors.solve(scale * b)

    def _krylov(self, K, b, tolerance):
        blocks = _diagonal_blocks(K, self._dim)
        diagonal = (self.T.T @ sparse.csr_array(blocks) @ self.T).diagonal()
        scale = _scale(diagonal)

        def apply(x):
            return scale * (self._test.T @ (K @ (self.T @ (scale * x)))) + FAINT * x

        operator = linalg.LinearOperator((len(b), len(b)), apply)
        size = float(np.abs(K.data).max(initial=0.0))
        alike = self._test is self.T and _symmetric(K, size)
        method = linalg.cg if alike else linalg.bicgstab

        def count(_):
            self.iterations += 1

        x, failed = method(operator, scale * b, rtol=tolerance, atol=0.0, maxiter=MOST_ITERATIONS, callback=count)
        if failed < 0:
            raise Singular("the iterations broke down")
        return scale * x


def _scale(diagonal):
    """1 / sqrt of the diagonal; 1 where it is nothing."""
    size = np.abs(diagonal)
    return 1.0 / np.sqrt(np.where(size > 1e-300, size, 1.0))


def _symmetric(K, size):
    """Whether K is symmetric, but for the error of tangents; looked at in one random product."""
    x = np.cos(np.arange(K.shape[0], dtype=float) ** 2)
    y = K @ x
    return float(np.linalg.norm(y - K.T @ x)) <= 1e-5 * max(float(np.linalg.norm(y)), 1e-300)


def _diagonal_blocks(K, dim):
    """The dim x dim blocks on the diagonal of a block matrix."""
    rows = np.repeat(np.arange(len(K.indptr) - 1), np.diff(K.indptr))
    own = K.indices == rows
    n = len(K.indptr) - 1
    return sparse.bsr_array((K.data[own], K.indices[own], np.arange(n + 1)), shape=K.shape)

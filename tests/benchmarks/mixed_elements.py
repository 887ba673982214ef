"""Cook's membrane and a strip footing by mixed finite elements, which do not lock: the reference of case I6; a table.

    pip install scikit-fem
    python tests/benchmarks/mixed_elements.py [-o FOLDER]

Triangles with displacements of second order and pressures of first (Taylor and Hood), at small strain. The cases are
described in `tests/support/locking.py`, whose numbers they share. Radial return with its consistent tangent (de Souza
Neto, Peric & Owen 2008, section 7.3); loads are applied in turn.
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np
from scipy.sparse import block_array
from skfem import (
    Basis,
    BilinearForm,
    ElementTriP1,
    ElementTriP2,
    ElementVector,
    LinearForm,
    MeshQuad,
    MeshTri,
    condense,
    solve,
)
from skfem.helpers import ddot, div, sym_grad

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.support.locking import DEPTH, HALF_STRIP, NEARLY, NU, PRANDTL, STIFFNESS, WIDTH

LOADS = (1.0, 2.0, 3.0, 3.5, 4.0, 4.25, 4.5, 4.75, 5.0, 0.98 * PRANDTL, 1.02 * PRANDTL)
GROWTH = 1.12
"""Of the elements of the footing, away from the edge of the strip."""
FARTHEST = 48.0
"""Displacement [m] from which on there is no balance."""
PARTS = 5
"""Steps from load to load."""
EYE = np.eye(3)
DEVIATORIC = (0.5 * (np.einsum("ik,jl->ijkl", EYE, EYE) + np.einsum("il,jk->ijkl", EYE, EYE))
              - np.einsum("ij,kl->ijkl", EYE, EYE) / 3.0)


@LinearForm
def _of_stress(v, w):
    return ddot(w["s"], sym_grad(v))


@BilinearForm
def _of_tangent(u, v, w):
    return np.einsum("ij...,ijkl...,kl...->...", sym_grad(v), w["D"], sym_grad(u))


@BilinearForm
def _of_pressure(u, q, _):
    return div(u) * q


@BilinearForm
def _of_volume(p, q, _):
    return p * q


class Mixed:
    """Equations of a mesh. fixed: displacements that do not move; load: forces (displacements,) of a load of 1."""

    def __init__(self, mesh, modulus, nu, yield_stress=np.inf):
        self.u = Basis(mesh, ElementVector(ElementTriP2()), intorder=4)
        p = self.u.with_element(ElementTriP1())
        self.G, K = 0.5 * modulus / (1.0 + nu), modulus / 3.0 / (1.0 - 2.0 * nu)
        self.radius = np.sqrt(2.0 / 3.0) * yield_stress
        self.B, self.C = _of_pressure.assemble(self.u, p), -_of_volume.assemble(p) / K
        self.x, self.plastic = np.zeros(self.u.N + p.N), 0.0

    def loaded(self, where, traction):
        """Forces of a traction (2,) on the sides where `where`(x)."""
        sides = self.u.boundary(self.u.mesh.facets_satisfying(where))
        return LinearForm(lambda v, _: traction[0] * v[0] + traction[1] * v[1]).assemble(sides)

    def _stress(self):
        """Deviator (3, 3, ...) and its tangent by the return map, and the new plastic strain."""
        gradient = self.u.interpolate(self.x[:self.u.N]).grad
        strain = np.zeros((3, 3, *gradient.shape[2:]))
        strain[:2, :2] = 0.5 * (gradient + np.swapaxes(gradient, 0, 1))
        strain -= EYE[..., None, None] * np.trace(strain) / 3.0
        trial = 2.0 * self.G * (strain - self.plastic)
        size = np.maximum(np.sqrt((trial**2).sum(axis=(0, 1))), 1e-300)
        share, n = np.minimum(1.0, self.radius / size), trial / size
        flow = np.where(share < 1.0, share, 0.0)
        D = 2.0 * self.G * (share * DEVIATORIC[..., None, None] - flow * np.einsum("ij...,kl...->ijkl...", n, n))
        return share * trial, D, strain - share * trial / (2.0 * self.G)

    def balance(self, force, fixed):
        """Find the balance with forces, from the last one; whether there is one."""
        N, start = self.u.N, self.x
        for _ in range(40):
            s, D, plastic = self._stress()
            u, p = self.x[:N], self.x[N:]
            left = np.concatenate([_of_stress.assemble(self.u, s=s[:2, :2]) + self.B.T @ p - force,
                                   self.B @ u + self.C @ p])
            left[fixed] = 0.0
            if np.linalg.norm(left[:N]) < 1e-9 * np.linalg.norm(force):
                self.plastic = plastic
                return True
            K = block_array([[_of_tangent.assemble(self.u, D=D[:2, :2, :2, :2]), self.B.T], [self.B, self.C]],
                            format="csr")
            self.x = self.x + solve(*condense(K, -left, D=fixed))
            if not np.abs(self.x[:N]).max() < FARTHEST:
                break
        self.x = start
        return False


def cook(n):
    """[(load, result, unknowns)], n elements along each side."""
    square = MeshQuad.init_tensor(*2 * [np.linspace(0.0, 1.0, n + 1)]).to_meshtri()
    x, y = square.p
    problem = Mixed(MeshTri(np.array([48.0 * x, 44.0 * x + y * (44.0 - 28.0 * x)]), square.t), 1.0, NEARLY)
    force = problem.loaded(lambda x: np.isclose(x[0], 48.0), (0.0, 1.0 / 16.0))
    held = problem.u.get_dofs(problem.u.mesh.facets_satisfying(lambda x: np.isclose(x[0], 0.0))).flatten()
    problem.balance(force, held)
    return [(1.0, force @ problem.x[:problem.u.N], len(problem.x))]


def _graded(length, first):
    """Steps from 0 to a length that grow from about `first`."""
    n = int(np.ceil(np.log1p(length / first * (GROWTH - 1.0)) / np.log(GROWTH)))
    at = np.cumsum(np.concatenate([[0.0], GROWTH ** np.arange(n)]))
    return at * length / at[-1]


def footing(n):
    """[(load, result, unknowns)] of the loads that are borne; the least elements are half of the strip over n."""
    first = HALF_STRIP / n
    x = np.concatenate([HALF_STRIP - _graded(HALF_STRIP, first)[::-1],
                        HALF_STRIP + _graded(WIDTH - HALF_STRIP, first)[1:]])
    mesh = MeshTri.init_tensor(x, DEPTH - _graded(DEPTH, first)[::-1])
    problem = Mixed(mesh, STIFFNESS, NU, np.sqrt(3.0))
    force = problem.loaded(lambda x: np.isclose(x[1], DEPTH) & (x[0] < HALF_STRIP + 1e-9), (0.0, -1.0))
    smooth = mesh.facets_satisfying(lambda x: np.isclose(x[0], 0.0) | np.isclose(x[0], WIDTH))
    ground = mesh.facets_satisfying(lambda x: np.isclose(x[1], 0.0))
    held = np.concatenate([problem.u.get_dofs(smooth).all("u^1"), problem.u.get_dofs(ground).flatten()])
    found = []
    for last, load in zip((0.0, *LOADS[:-1]), LOADS, strict=True):
        if not all(problem.balance(part * force, held) for part in np.linspace(last, load, PARTS + 1)[1:]):
            break
        found.append((load, force @ problem.x[:problem.u.N] / HALF_STRIP, len(problem.x)))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "figures")
    options = parser.parse_args()
    with open(options.output / "mixed_elements.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("case", "elements", "unknowns", "load", "result"))
        for case, sizes in ((cook, (16, 32, 64)), (footing, (6, 12, 24))):
            for n in sizes:
                for load, result, unknowns in case(n):
                    writer.writerow((case.__name__, n, unknowns, load, f"{result:.6g}"))
                    print(case.__name__, n, unknowns, load, f"{result:.6g}", flush=True)


if __name__ == "__main__":
    main()

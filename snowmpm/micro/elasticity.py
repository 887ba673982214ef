"""Elastic tensor of the ice skeleton of a sample, by finite elements on its voxels.

Each voxel of ice is a brick with eight nodes and linear shape functions. For a mean strain E the periodic displacement
u~ makes the stress balanced:

    integral of eps(v) : C_ice : (E + eps(u~)) = 0 for all periodic v,    C : E = mean of C_ice : (E + eps(u~))

(Michel, Moulinec and Suquet 1999, doi:10.1016/S0045-7825(98)00227-8; on voxels Garboczi 1998, NISTIR 6269). The pores
carry nothing. The stiffness of bricks is too high, and falls to the right one with finer voxels. Six strains give C, in
Voigt's order xx, yy, zz, yz, xz, xy with engineering shear.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from scipy import ndimage, sparse

from snowmpm import memory
from snowmpm.stages import stage

ICE = 9.5e9, 0.33
"""Young's modulus [Pa] and Poisson's ratio of polycrystalline ice near -10 C."""

ICE_SOURCE = "ice of 9.5 GPa and 0.33, Petrovic (2003), doi:10.1023/A:1021134128038"

BYTES = 24 * 8 * 6
"""Memory of a voxel of ice: displacements and forces of its corners, their places, and copies."""

MOST = 4000
"""Iterations."""

CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))
VOIGT = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@dataclass(frozen=True)
class ElasticTensor:
    """stiffness (6, 6) [Pa], Voigt's order; work (6, 6) [Pa]: mean of eps : C_ice : eps for pairs of the six strains,
    the same by Hill and Mandel; iterations (6,); remaining (6,): what is left of the imbalance, relative."""

    stiffness: np.ndarray
    work: np.ndarray
    iterations: np.ndarray
    remaining: np.ndarray

    @property
    def isotropic(self):
        """Young's modulus [Pa] and Poisson's ratio of the nearest isotropic tensor (mean over all directions)."""
        C = self.stiffness
        bulk = C[:3, :3].sum() / 9.0
        shear = (np.trace(C[:3, :3]) - C[:3, :3].sum() / 3.0 + 2.0 * np.trace(C[3:, 3:])) / 10.0
        if bulk <= 0.0 or shear <= 0.0:
            return 0.0, 0.0
        return 9.0 * bulk * shear / (3.0 * bulk + shear), (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear))

    @property
    def confined(self):
        """Moduli of confined compression along x, y and z [Pa]."""
        return np.diag(self.stiffness)[:3]


def elastic_tensor(ice, moduli=ICE, tolerance=1e-5):
    """`ElasticTensor` of an image (nx, ny, nz), periodic along all axes.

    ice: True in ice; or numbers, of the phases, whose Young's modulus [Pa] and Poisson's ratio are the rows of moduli,
    0 of a pore. tolerance: of the imbalance. Memory is asked for before. InputError when there is too little.
    """
    phases = np.asarray(ice).astype(int)
    table = np.array([(0.0, 0.0), moduli]) if np.ndim(moduli) == 1 else np.array(moduli, float)
    solid = _held(table[phases, 0] > 0.0)
    if not solid.any():
        return ElasticTensor(np.zeros((6, 6)), np.zeros((6, 6)), np.zeros(6, int), np.zeros(6))
    memory.require(float(BYTES) * solid.sum() + 50.0 * phases.size, "SAMPLE: the ice of the image", "")
    skeleton = _Skeleton(solid, phases, table)
    loads, found = skeleton.loads, np.zeros_like(skeleton.loads)
    iterations, remaining = np.zeros(6, int), np.zeros(6)
    with stage("elastic tensor") as now:
        for k in range(6):
            found[:, k], iterations[k], remaining[k] = _balanced(skeleton, -loads[:, k], tolerance, now)
    volume, forces = float(phases.size), np.stack([skeleton.forces(u) for u in found.T], axis=1)
    stiffness = (skeleton.direct + loads.T @ found) / volume
    work = (skeleton.direct + found.T @ loads + loads.T @ found + found.T @ forces) / volume
    return ElasticTensor(stiffness, work, iterations, remaining)


def _held(solid):
    """The largest piece of what is solid, through faces and over periodic sides: what floats carries nothing."""
    labels, count = ndimage.label(solid)
    first, second = [], []
    for axis in range(3):
        ends = labels.take(0, axis).ravel(), labels.take(-1, axis).ravel()
        both = (ends[0] > 0) & (ends[1] > 0)
        first.append(ends[0][both])
        second.append(ends[1][both])
    graph = sparse.coo_array((np.ones(sum(map(len, first)), np.int8), (np.concatenate(first), np.concatenate(second))),
                             shape=(count + 1, count + 1))
    _, name = sparse.csgraph.connected_components(graph, directed=False)
    sizes = np.bincount(name[labels[solid]], minlength=1)
    return solid & (name[labels] == int(np.argmax(sizes)))


def _brick(young, poisson):
    """Stiffness (24, 24) of a brick of side 1, its loads (24, 6) by unit strains, and their direct part (6, 6)."""
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
    C = np.diag([2 * shear] * 3 + [shear] * 3)
    C[:3, :3] += lame
    K, loads = np.zeros((24, 24)), np.zeros((24, 6))
    for point in itertools.product(0.5 + np.array([-1, 1]) / np.sqrt(12.0), repeat=3):
        factors = np.where(CORNERS == 1, point, 1.0 - np.array(point))
        slopes = np.where(CORNERS == 1, 1.0, -1.0)
        B = np.zeros((6, 24))
        for corner in range(8):
            d = [slopes[corner, a] * factors[corner, (a + 1) % 3] * factors[corner, (a + 2) % 3] for a in range(3)]
            for row, (i, j) in enumerate(VOIGT):
                B[row, 3 * corner + i] += d[j]
                if i != j:
                    B[row, 3 * corner + j] += d[i]
        K += B.T @ C @ B / 8.0
        loads += B.T @ C / 8.0
    return K, loads, C


class _Skeleton:
    """Bricks of the solid voxels. loads (n, 6): forces of unit strains on the n displacements; direct (6, 6): stress
    without displacements, summed; diagonal (n,) of the stiffness, which is never put together."""

    def __init__(self, solid, phases, table):
        at = np.argwhere(solid)
        corners = (at[:, None] + CORNERS) % np.array(solid.shape)
        flat = np.ravel_multi_index(corners.reshape(-1, 3).T, solid.shape)
        nodes, place = np.unique(flat, return_inverse=True)
        places = (3 * place.reshape(-1, 8, 1) + np.arange(3)).reshape(len(at), 24)
        self.count, of = 3 * len(nodes), phases[solid]
        self._parts = []
        self.loads, self.diagonal, self.direct = np.zeros((self.count, 6)), np.zeros(self.count), np.zeros((6, 6))
        for phase in np.unique(of):
            own = places[of == phase]
            K, load, C = _brick(*table[phase])
            self._parts.append((own, K))
            self.diagonal += self._summed(own, np.tile(np.diag(K), (len(own), 1)))
            for k in range(6):
                self.loads[:, k] += self._summed(own, np.tile(load[:, k], (len(own), 1)))
            self.direct += len(own) * C

    def forces(self, u):
        """Of displacements u (n,), at the nodes (n,)."""
        return sum(self._summed(own, u[own] @ K) for own, K in self._parts)

    def _summed(self, own, values):
        return np.bincount(own.ravel(), values.ravel(), minlength=self.count)


def _balanced(skeleton, load, tolerance, now):
    """Displacement by conjugate gradients, iterations, and what is left of the imbalance over the load's."""
    u, r, diagonal = np.zeros_like(load), load.copy(), skeleton.diagonal
    start = float(np.linalg.norm(r))
    if start < 1e-14 * diagonal.max() * np.sqrt(len(r)):
        return u, 0, 0.0
    z = r / diagonal
    p, rz = z.copy(), float(r @ z)
    count, left = 0, 1.0
    while count < MOST and left > tolerance:
        q = skeleton.forces(p)
        step = rz / float(p @ q)
        u += step * p
        r -= step * q
        z = r / diagonal
        rz, before = float(r @ z), rz
        p = z + (rz / before) * p
        count += 1
        left = float(np.linalg.norm(r)) / start
        now.done = count
    return u, count, left

"""What a scene is made of before a solver takes it: points with volume, material, velocity and initial stress."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Population:
    """positions (n, dim) [m, scene coordinates], velocities (n, dim) [m/s], volumes (n,) [m3], material (n,) index.

    elastic: the laws' elastic variable be - I, stress: Kirchhoff stress [Pa]; both (n, 4) in plane strain or (n, 6),
    in the order xx, yy, zz, xy[, yz, xz]; zero where not given. field (n,): velocity field, 0 for all that moves as one
    continuum.
    """

    positions: np.ndarray
    volumes: np.ndarray
    material: np.ndarray
    velocities: np.ndarray | None = None
    elastic: np.ndarray | None = None
    stress: np.ndarray | None = None
    field: np.ndarray | int = 0

    def __post_init__(self):
        n, dim = self.positions.shape
        symmetric = 4 if dim == 2 else 6
        self.material = np.broadcast_to(np.asarray(self.material, np.int32), n).copy()
        self.velocities = np.zeros((n, dim)) if self.velocities is None else np.asarray(self.velocities, float)
        self.elastic = np.zeros((n, symmetric)) if self.elastic is None else self.elastic
        self.stress = np.zeros((n, symmetric)) if self.stress is None else self.stress
        self.field = np.broadcast_to(np.asarray(self.field, np.int64), n).copy()

"""The particles of a step as NumPy columns of float64, whatever the store keeps them in."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from snowmpm.implicit.response import Before
from snowmpm.particles.store import IDENTITY, MATERIAL


@dataclass
class MaterialPoints:
    """Columns of particles (n, ...): cells [cells], velocity [m/s], volume at the reference [m3], mass [kg], material,
    number, h, tau [Pa] (n, 4 or 6), state, ratio J, affine (n, dim, dim) [1/s]; around: pressure around the snow [Pa]
    (n,), None without; columns: of components, by name; terms: `kernel_api.Term`s, strain: (mesh, matter) ->
    `kernel_api.Strain` of components."""

    cells: np.ndarray
    velocity: np.ndarray
    volume: np.ndarray
    mass: np.ndarray
    material: np.ndarray
    number: np.ndarray
    h: np.ndarray
    tau: np.ndarray
    state: np.ndarray
    ratio: np.ndarray
    affine: np.ndarray
    around: np.ndarray | None = None
    columns: dict = field(default_factory=dict)
    terms: list = field(default_factory=list)
    strain: Callable | None = None

    @classmethod
    def of_store(cls, store):
        """Those of a `SortedParticles`."""
        labels, dim = store.labels(), store.dim
        cells = (store.positions() - store.origin) / store.dx
        columns = {name: store.column(name) for name in ("velocity", "volume", "elastic", "stress", "state",
                                                         "volume_ratio", "affine")}
        material = labels[:, MATERIAL]
        volume = columns["volume"][:, 0]
        own = {name: store.column(name) for name, _ in store.layout.more}
        return cls(cells, columns["velocity"], volume, store.masses(), material,
                   labels[:, IDENTITY], columns["elastic"], columns["stress"], columns["state"],
                   columns["volume_ratio"][:, 0], columns["affine"].reshape(-1, dim, dim), columns=own)

    @classmethod
    def of_population(cls, population, materials, origin, dx):
        """Those of a `Population`; materials: its `MaterialTable`."""
        rows = np.arange(len(population.volumes))
        n, dim = population.positions.shape
        return cls((population.positions - origin) / dx, population.velocities.copy(), population.volumes,
                   population.volumes * materials.density[population.material], population.material, rows,
                   population.elastic.copy(), population.stress.copy(), materials.state_of(population, rows),
                   population.volume_ratio.copy(), population.affine.reshape(n, dim, dim).copy())

    def before(self):
        """What their laws read (`response.Before`)."""
        return Before(np.ascontiguousarray(self.h), np.ascontiguousarray(self.state), np.ascontiguousarray(self.ratio),
                      np.ascontiguousarray(self.material, np.int32))

    def changed(self):
        """Columns of a `ParticleStore` by name, but for places."""
        return {"velocity": self.velocity, "affine": self.affine, "elastic": self.h, "stress": self.tau,
                "state": self.state, "volume_ratio": self.ratio, **self.columns}

    def take(self, after):
        """Take over what a step made of them (`response.After`)."""
        self.h, self.tau, self.state, self.ratio = after.h, after.tau, after.state, after.ratio

"""Particle fields by name, as output, diagnostics and users read them: NumPy copies in SI units."""

import numpy as np

from snowmpm.materials import LAWS

UNITS = {
    "position": "m", "velocity": "m/s", "density": "kg/m3", "mass": "kg", "volume": "m3", "stress": "Pa", "p": "Pa",
    "q": "Pa", "J": "1", "material": "1", "body": "1", "id": "1",
    **{name: unit.replace("-", "1") for law in LAWS.values() for name, unit in law.OUTPUTS.items()},
}


class ParticleFields:
    """`fields[name]`: one array a name, copied when asked for; one table copy serves all names.

    velocity (n, dim) [m/s]; density: current [kg/m3]; stress: Cauchy (n, 6) [Pa], xx, yy, zz, xy, yz, xz of the tensor
    axes (in 2-D: axis 0 = x, 1 = z, 2 = out of plane); p = -tr(sigma)/3 and q = sqrt(3/2 s:s) of it; volume: current;
    J = det F; material, body: index in the scene; id: number given at seeding; and what the laws report of their state
    (their OUTPUTS: p0, damage, plastic_strain, gap ...), zero where a law has no such thing.
    """

    def __init__(self, particles, body_starts=(0,)):
        self._particles = particles
        self._table = particles.table()
        self._labels = particles.labels()
        self._blocks = particles.blocks  # a sort makes a new one; the table belongs to this one
        self._body_starts = np.asarray(body_starts)

    def __repr__(self):
        return f"ParticleFields({len(self._labels)} particles: {', '.join(sorted(UNITS))})"

    def __getitem__(self, name):
        method = getattr(self, f"_{name}", None)
        if method is not None:
            return method()
        if name in UNITS:
            return self._of_laws(name)
        raise KeyError(f"no particle field {name!r}; there are {', '.join(sorted(UNITS))}")

    def __contains__(self, name):
        return name in UNITS

    def __iter__(self):
        return iter(UNITS)

    def _column(self, name):
        return self._table[:, self._particles.layout.columns(name)].astype(np.float64)

    def _position(self):
        return self._particles.positions(self._column("position"), self._blocks)

    def _velocity(self):
        return self._column("velocity")

    def _J(self):
        return self._column("volume_ratio")[:, 0]

    def _volume(self):
        return self._column("volume")[:, 0] * self._J()

    def _mass(self):
        return self._column("volume")[:, 0] * self._particles.materials.density[self._material()]

    def _density(self):
        return self._particles.materials.density[self._material()] / self._J()

    def _material(self):
        return self._labels[:, 0]

    def _id(self):
        return self._labels[:, 1]

    def _body(self):
        return np.searchsorted(self._body_starts, self._id(), side="right") - 1

    def kirchhoff(self):
        """Kirchhoff stress (n, 6) [Pa]."""
        tau = self._column("stress")
        return tau if tau.shape[1] == 6 else np.pad(tau, ((0, 0), (0, 2)))

    def velocity_gradient(self):
        """grad v (n, dim * dim) [1/s], row major: the affine part of a particle's motion."""
        return self._column("affine")

    def state(self):
        """State of the law of each particle (n, largest number of state variables)."""
        return self._column("state")

    def _stress(self):
        return self.kirchhoff() / self._J()[:, None]

    def _p(self):
        return -self._stress()[:, :3].mean(axis=1)

    def _q(self):
        sigma = self._stress()
        s = sigma[:, :3] - sigma[:, :3].mean(axis=1, keepdims=True)
        return np.sqrt(1.5 * (s**2).sum(axis=1) + 3.0 * (sigma[:, 3:] ** 2).sum(axis=1))

    def _of_laws(self, name):
        material, values = self._material(), np.zeros(len(self._labels))
        for m, law in enumerate(self._particles.materials.laws):
            own = material == m
            state = self.state()[own]
            values[own] = law.outputs(state[:, : len(law.STATE)]).get(name, 0.0)
        return values

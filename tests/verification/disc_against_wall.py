"""A disc thrown against a smooth rigid wall, by finite elements: what the particles of M16 are compared with.

Triangles of constant strain on rings of nodes, lumped masses, central differences, Hencky elasticity in plane strain;
the wall takes from a node the velocity that would carry it through. By symmetry the wall is the plane between two
discs that meet head on. Nothing of the program is used.

    tau = lambda tr(eps) 1 + 2 mu eps,   eps = ln(F F^T) / 2,   force of a triangle on its nodes = -A tau F^-T D^-T
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay


@dataclass(frozen=True)
class Disc:
    """E [Pa], nu, rho [kg/m3], radius [m], and rings of elements."""

    youngs_modulus: float
    poisson_ratio: float
    density: float
    radius: float
    rings: int

    def mesh(self):
        """Nodes (n, 2) [m] and triangles (k, 3), counter-clockwise."""
        rings = [np.zeros((1, 2))]
        for k in range(1, self.rings + 1):
            angle = 2.0 * np.pi * (np.arange(6 * k) + 0.5 * (k % 2)) / (6 * k)
            rings.append(self.radius * k / self.rings * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        nodes = np.concatenate(rings)
        triangles = Delaunay(nodes).simplices
        area = np.linalg.det(_edges(nodes, triangles))
        triangles[area < 0.0] = triangles[area < 0.0][:, [0, 2, 1]]
        return nodes, triangles[np.abs(area) > 1e-3 * (self.radius / self.rings) ** 2]

    def stress(self, F):
        """Kirchhoff stress (k, 2, 2) [Pa] and energy per volume [J/m3]."""
        E, nu = self.youngs_modulus, self.poisson_ratio
        lam, mu = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu))
        b = F @ F.transpose(0, 2, 1)
        mean, radius = 0.5 * (b[:, 0, 0] + b[:, 1, 1]), np.hypot(0.5 * (b[:, 0, 0] - b[:, 1, 1]), b[:, 0, 1])
        first, second = 0.5 * np.log(mean + radius), 0.5 * np.log(mean - radius)
        # Both share their axes with b: tau = (lam + mu) (first + second) 1 + slope (b - mean 1)
        slope = np.where(radius > 1e-14, mu * (first - second) / np.maximum(radius, 1e-14), mu / mean)
        volume = first + second
        tau = slope[:, None, None] * b
        tau[:, [0, 1], [0, 1]] += ((lam + mu) * volume - slope * mean)[:, None]
        return tau, 0.5 * lam * volume**2 + mu * (first**2 + second**2)

    def thrown(self, speed, duration, courant=0.4):
        """A row for each step: time [s], velocity of the centre over `speed`, kinetic and elastic energy over the
        kinetic one at the start, whether the wall is touched. It starts a thousandth of the radius off the wall."""
        nodes, triangles = self.mesh()
        edges = _edges(nodes, triangles)
        area, inverse = 0.5 * np.linalg.det(edges), np.linalg.inv(edges)
        mass = np.bincount(triangles.ravel(), np.repeat(self.density * area / 3.0, 3))
        x, v, wall = nodes.copy(), np.tile([speed, 0.0], (len(nodes), 1)), 1.001 * self.radius
        E, nu = self.youngs_modulus, self.poisson_ratio
        faster = np.sqrt(E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)) / self.density)
        dt = courant * 0.7 * self.radius / self.rings / faster
        start, rows = 0.5 * mass.sum() * speed**2, []
        for step in range(round(duration / dt)):
            F = _edges(x, triangles) @ inverse
            tau, energy = self.stress(F)
            pull = -area[:, None, None] * tau @ np.linalg.inv(F).transpose(0, 2, 1) @ inverse.transpose(0, 2, 1)
            force = np.stack([np.bincount(triangles.ravel(), np.stack(
                [-pull[:, a].sum(axis=1), pull[:, a, 0], pull[:, a, 1]], axis=1).ravel()) for a in range(2)], axis=1)
            v += dt * force / mass[:, None]
            through = x[:, 0] + dt * v[:, 0] > wall
            v[through, 0] = (wall - x[through, 0]) / dt
            x += dt * v
            rows.append(((step + 1) * dt, mass @ v[:, 0] / mass.sum() / speed,
                         0.5 * mass @ (v**2).sum(axis=1) / start, area @ energy / start, through.any()))
        return np.array(rows)


def _edges(nodes, triangles):
    """Edges from the first corner of each triangle as columns, (k, 2, 2)."""
    corners = nodes[triangles]
    return np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)

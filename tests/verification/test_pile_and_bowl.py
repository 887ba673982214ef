"""Avalanches without a preferred direction (M20): a bowl, down which every release runs as far, and a heap of grains
that a rough bed holds up to its friction angle."""

import numpy as np
import pytest

from snowmpm.materials import DruckerPrager
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.schemes import APIC, lattice

G = 9.81


class Bowl:
    """Terrain outside a sphere that touches z = 0 at the origin."""

    def __init__(self, radius):
        self.radius, self.centre = radius, np.array([0.0, 0.0, radius])

    def query(self, points):
        inwards = self.centre - points
        reach = np.linalg.norm(inwards, axis=1)
        return self.radius - reach, inwards / np.maximum(reach, 1e-12)[:, None]


class Floor:
    """Terrain below z = level."""

    def __init__(self, level):
        self.level = level

    def query(self, points):
        return points[:, 2] - self.level, np.broadcast_to([0.0, 0.0, 1.0], points.shape)


def turned(points, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def solver_of(positions, volumes, terrain, friction, dx, law):
    lower, upper = np.array([-9.6, -9.6, -0.8]), np.array([9.6, 9.6, 8.8])
    return MpmSolver(Population(positions, volumes, 0), [law], dx=dx, precision="f32", origin=lower, lower=lower,
                     upper=upper, gravity=np.array([0.0, 0.0, -G]), terrain=terrain, terrain_contact="separate",
                     terrain_friction=friction, **APIC.options)


@pytest.mark.slow
def test_every_direction_of_a_bowl_is_the_same():
    """A block let go on the wall of a bowl of 10 m, turned by 0, 120 and 225 degrees: it slides through the bottom, up
    the other side and back. Run-out: the furthest that 99 % of it have come along its way."""
    dx, steep = 0.3, np.radians(50.0)
    law = DruckerPrager(density=300.0, youngs_modulus=2e5, poisson_ratio=0.3, friction_angle=30.0)
    local, volumes = lattice([-1.0, -1.0, 0.0], [1.0, 1.0, 0.6], dx)
    bowl = Bowl(10.0)
    # The block lies on the sphere: its plan bent along the wall, its height towards the centre
    polar, across = steep + local[:, 0] / bowl.radius, local[:, 1] / bowl.radius
    reach = bowl.radius - local[:, 2]
    release = bowl.centre + np.column_stack([-reach * np.sin(polar) * np.cos(across), reach * np.sin(across),
                                             -reach * np.cos(polar) * np.cos(across)])
    furthest = []
    for angle in (0.0, 120.0, 225.0):
        solver = solver_of(turned(release, angle), volumes, bowl, 0.2, dx, law)
        along = []
        while solver.time < 4.0:
            for _ in range(20):
                solver.step(solver.stable_dt()[0])
            along.append(np.quantile(turned(solver.particles.positions(), -angle)[:, 0], 0.01))
            along.append(np.quantile(turned(solver.particles.positions(), -angle)[:, 0], 0.99))
        furthest.append(max(along))
    assert min(furthest) > 1.0  # beyond the bottom
    assert np.ptp(furthest) < dx


@pytest.mark.slow
@pytest.mark.parametrize(("share", "stays"), [(0.8, True), (1.25, False)])
def test_conical_pile(share, stays):
    """A cone of grains on a Coulomb bed, its slope 0.8 and 1.25 times tan(delta), delta = 21 degrees. The grains' own
    friction is that of the bed in steady shear, sin(phi) = tan(delta), as in the sheets of test_depth_averaged."""
    dx, radius, friction = 0.15, 2.25, np.tan(np.radians(21.0))
    height = share * friction * radius
    local, volumes = lattice([-radius, -radius, 0.0], [radius, radius, np.ceil(height / dx) * dx], dx)
    inside = local[:, 2] < height * (1.0 - np.hypot(local[:, 0], local[:, 1]) / radius)
    law = DruckerPrager(density=1000.0, youngs_modulus=5e5, poisson_ratio=0.3, cone="plane_strain",
                        friction_angle=float(np.degrees(np.arcsin(friction))))
    level = 0.3 * dx
    solver = solver_of(local[inside] + [0.0, 0.0, level], volumes[inside], Floor(level), friction, dx, law)
    spread = [np.hypot(*solver.particles.positions()[:, :2].T).mean()]
    for end in (0.4, 1.0):
        while solver.time < end:
            solver.step(solver.stable_dt()[0])
        spread.append(np.hypot(*solver.particles.positions()[:, :2].T).mean())
    if stays:
        assert spread[-1] - spread[0] < 0.02 * dx  # it settles elastically
    else:
        assert spread[-1] - spread[0] > 0.2 * dx

"""A block on an incline with Coulomb friction (M12): it slides with a = g (sin theta - mu cos theta), stays below the
friction angle, and lifts off freely, however the incline lies in the grid.

Block 0.10 x 0.05 m, E = 1 MPa, nu = 0.3, rho = 1000 kg/m3 (the set-up of `matter`, whose test allows 1e-3), h = 0.01 m.
"""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from tests.verification.rigid_walls import Plane
from tests.verification.schemes import lattice

H, G = 0.01, 9.81
SLOPE, FRICTION = np.deg2rad(24.0), np.tan(np.deg2rad(15.0))
EXACT = G * (np.sin(SLOPE) - FRICTION * np.cos(SLOPE))  # 1.58875771 m/s2
RUBBER = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3)


class Block:
    """Block on a plane that dips by `slope` against gravity and by `tilt` against the grid [rad]; the surface is
    `offset` cells off a node."""

    def __init__(self, slope, friction, tilt, offset=0.3, lift=0.0, transfer="apic"):
        plane = Plane(-tilt)
        self.along, self.up = plane.along, plane.normal
        local, volumes = lattice([0.0, 0.0], [0.10, 0.05], H)
        self.start = local[:, :1] * self.along + (local[:, 1:] + offset * H) * self.up
        plane.point = offset * H * self.up
        self.gravity = G * (np.sin(slope) * self.along - np.cos(slope) * self.up) + lift * self.up
        self.solver = MpmSolver(
            Population(self.start, volumes, 0), [RUBBER], dx=H, precision="f64", origin=np.zeros(2),
            lower=[-40.0, -40.0], upper=[40.0, 40.0], gravity=self.gravity, terrain=plane,
            terrain_contact="separate", terrain_friction=friction, transfer=transfer)

    def run(self, end):
        while self.solver.time < end:
            self.solver.step(min(self.solver.stable_dt()[0], end - self.solver.time + 1e-12))
        return self

    def velocity(self):
        return self.solver.masses() @ self.solver.column("velocity") / self.solver.mass

    def displacement(self):
        return self.solver.positions() - self.start[self.solver.particles.labels()[:, 1]]


def acceleration(tilt, end, offset=0.3):
    """Mean along the plane from the start [m/s2]: the elastic block hops a little as it is let go."""
    block = Block(SLOPE, FRICTION, tilt, offset).run(end)
    return block.velocity() @ block.along / block.solver.time


@pytest.mark.parametrize("tilt, offset", [(24.0, 0.3), (24.0, 0.3 + 1 / 3), (54.0, 0.3), (-66.0, 0.0)])
def test_acceleration(tilt, offset):
    """Along the slope of the set-up, shifted by a third of a cell, turned by 30 and by 90 degrees."""
    assert acceleration(np.deg2rad(tilt), 0.5, offset) == pytest.approx(EXACT, rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("tilt", np.arange(0.0, 91.0, 7.0))
def test_acceleration_at_every_angle_to_the_grid(tilt):
    assert acceleration(np.deg2rad(tilt), 2.5) == pytest.approx(EXACT, rel=2e-3)


def creep(tilt, start, end):
    """Mean displacement along the plane between two times [cells], below the friction angle."""
    block = Block(np.deg2rad(15.0), np.tan(SLOPE), np.deg2rad(tilt)).run(start)
    before = (block.displacement() @ block.along).mean()
    return ((block.run(end).displacement() @ block.along).mean() - before) / H


@pytest.mark.parametrize("tilt", [0.0, 37.0])
def test_no_creep_below_the_friction_angle(tilt):
    assert abs(creep(tilt, 0.3, 0.6)) < 3e-5  # cells: 1e-3 in 10 s


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [15.0, 45.0])
def test_no_creep_in_ten_seconds(tilt):
    assert abs(creep(tilt, 0.3, 10.3)) < 1e-3


def test_lifts_off_freely():
    """Pulled off the plane by g / 2 it moves as if the plane were not there."""
    block = Block(np.deg2rad(24.0), FRICTION, np.deg2rad(24.0), lift=1.5 * G * np.cos(np.deg2rad(24.0))).run(0.1)
    t, dt = block.solver.time, block.solver.time / block.solver.steps
    fall = 0.5 * block.gravity * t * (t + dt)  # symplectic Euler
    np.testing.assert_allclose(block.displacement().mean(axis=0), fall, rtol=1e-6)
    assert np.abs(block.solver.impulse).max() < 1e-9

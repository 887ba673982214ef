"""U1: flow between plates is exact with two relaxation times, and the permeability does not depend on them."""

import numpy as np
import pytest

from snowmpm.micro.permeability import permeability
from snowmpm.micro.pore_lattice import pore_lattice
from snowmpm.micro.stokes_flow import StokesFlow
from tests.support.spheres import simple_cubic

FORCE = 1e-4
HEIGHT = 7


def plates(precision="f64", walls=True, **chosen):
    """Largest relative error of the settled velocity between plates; what is not chosen is the default."""
    pores = np.ones((4, 4, HEIGHT + (0 if walls else 1)), bool)
    if not walls:
        pores[:, :, -1] = False
    flow = StokesFlow(pore_lattice(pores, (False, False, walls)), [FORCE, 0.0, 0.0], precision=precision, **chosen)
    flow.advance(2000)
    z = np.arange(HEIGHT) + 0.5
    exact = FORCE / (2.0 * flow.viscosity) * z * (HEIGHT - z)
    velocity = flow.velocity()
    assert np.abs(velocity[:, 1:]).max() < (1e-12 if precision == "f64" else 1e-6) * velocity[:, 0].max()
    return np.abs(velocity[:HEIGHT, 0] / exact - 1.0).max()


@pytest.mark.parametrize("tau", [0.6, 1.0, 3.0])
def test_flow_between_plates_is_exact(tau):
    """With the default product of both times; 4/16 is off by 3 %."""
    assert plates(tau=tau) < 1e-10
    assert plates(tau=tau, magic=4.0 / 16.0) > 0.01


def test_a_plate_of_ice_is_a_wall():
    assert plates(walls=False) < 1e-10


def test_float32_is_enough():
    """All defaults."""
    assert plates("f32") < 1e-5


def test_with_one_relaxation_time_the_wall_moves():
    """What the second is for: an error of 3 to 60 per cent, that depends on the viscosity."""
    errors = [plates(tau=tau, magic=None) for tau in (0.6, 1.0, 1.8)]
    assert errors == pytest.approx([0.0728, 0.0256, 0.616], rel=0.01)


@pytest.mark.parametrize("width", [4, 9])
def test_permeability_of_a_slit_is_exact(width):
    """As a user calls it, with all defaults: (w^3 + w/2) / 12 over the height, the sum of a parabola over w voxels."""
    pores = np.zeros((3, 3, width + 2), bool)
    pores[:, :, 1:-1] = True
    found = permeability(pores, 1e-4, (0,)).mean
    assert found == pytest.approx((width**3 + 0.5 * width) / 12.0 / (width + 2) * 1e-8, rel=1e-3)


def test_permeability_does_not_depend_on_the_relaxation_time():
    """0.1 % asked; of a packing of spheres."""
    ice, _ = simple_cubic(20, 0.343)
    found = [permeability(~ice, 1.0, (0,), tau=tau, tolerance=1e-5).mean for tau in (0.8, 1.5, 3.0)]
    assert found == pytest.approx(np.full(3, found[0]), rel=1e-3)


def test_a_step_writes_each_number_once():
    """So that threads never meet, and their number leaves the bits alone."""
    ice, _ = simple_cubic(12, 0.216)
    lattice = pore_lattice(~ice)
    places = np.concatenate([np.arange(lattice.count)[None], lattice.table])
    assert np.array_equal(np.sort(places.ravel()), np.arange(19 * lattice.count))

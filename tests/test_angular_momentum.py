"""Angular momentum in the history: its definition, and what of it a method keeps.

Two blocks side by side that pass each other and stick: nothing outside turns them, so the balance is that it stays.
"""

import numpy as np
import pytest

from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

SPEED, SIDE, DX, DENSITY = 2.0, 0.4, 0.05, 300.0
NAMES = {2: "angular_momentum", 3: "angular_momentum_y"}


def passing(dim, method, speed=SPEED, **options):
    """The lower block goes one way, the upper one the other."""
    across = [0.2] * (dim - 2)
    half, none = 0.5 * SIDE, [0.0] * (dim - 2)
    bodies = [{"name": name, "material": "stuff", "velocity": [sign * speed, *none, 0.0],
               "shape": {"kind": "box", "min": [0.0, *none, low], "max": [SIDE, *across, low + half]}}
              for name, sign, low in (("lower", 1.0, 0.0), ("upper", -1.0, half))]
    return Simulation(Scene.model_validate({
        "name": "passing", "dimension": dim, "end_time": 1.0, "gravity": 0.0,
        "solver": {"method": method, "dx": DX, "precision": "f64", **options},
        "domain": {"min": [-1.0] * dim, "max": [1.5] * dim},
        "materials": {"stuff": {"kind": "elastic", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": bodies}))


def drift(simulation, name, n=60):
    """-> angular momentum at the start, largest change over it in n steps."""
    start = simulation.audit()[name]
    found = []
    for _ in range(n):
        simulation.step()
        found.append(simulation.audit()[name])
    return start, float(np.abs(np.array(found) / start - 1.0).max())


def test_what_it_is():
    """Of two blocks: m v times half of what their middles are apart, twice; from x towards z."""
    start = passing(2, "mpm").audit()["angular_momentum"]
    assert start == pytest.approx(2.0 * DENSITY * 0.5 * SIDE**2 * SPEED * 0.25 * SIDE, rel=1e-12)
    row = passing(3, "mpm").audit()  # z to x is the positive way about y
    assert row["angular_momentum_y"] == pytest.approx(-0.2 * start, rel=1e-12)
    assert abs(row["angular_momentum_x"]) + abs(row["angular_momentum_z"]) < 1e-12 * start


@pytest.mark.parametrize("dim", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_mpm_with_affine_transfers_keeps_it(dim):
    assert drift(passing(dim, "mpm", transfer="apic"), NAMES[dim])[1] < 1e-12


def test_mpm_without_them_does_not():
    assert drift(passing(2, "mpm", transfer="pic"), NAMES[2])[1] > 0.5


def test_sums_of_forces_by_squared_densities_turn_the_snow():
    """Conserved by forces along the line between two particles; a stress with a deviator makes others. Seen: 2.3 %."""
    assert 0.005 < drift(passing(2, "sph"), NAMES[2])[1] < 0.1


@pytest.mark.parametrize(("dim", "n"), [(2, 60), pytest.param(3, 30, marks=pytest.mark.slow)])
def test_corrected_sums_keep_it_but_for_the_strain(dim, n):
    """They do the work of a gradient that sees a rotation as none, but weigh stresses by squared densities where that
    sums volumes: both agree as far as neighbours are equally dense. Seen in 2-D at 2, 0.5, 0.125 m/s: 1.1e-4, 1.2e-5,
    2e-6; squared densities alone lose 2.3 % at any speed."""
    left = [drift(passing(dim, "sph", speed, sph={"momentum": "corrected"}), NAMES[dim], n)[1] for speed in (2.0, 0.5)]
    assert left[0] < 5e-4
    assert left[1] < 0.3 * left[0]

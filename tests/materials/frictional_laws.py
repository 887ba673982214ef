"""Examples of the frictional laws, and random steps from random admissible states of them."""

import functools
from dataclasses import dataclass

import numpy as np
from parameter_sets import random_rotations

from snowmpm.materials import (
    DruckerPrager,
    MohrCoulomb,
    MuI,
    MuPhiI,
    SofteningCone,
    StressUpdate,
    Updated,
    VonMises,
    unpack,
)

SOIL = {"density": 1500.0, "youngs_modulus": 1e7, "poisson_ratio": 0.3}
LAWS = {
    "von Mises": VonMises(**SOIL, yield_stress=2e4),
    "von Mises hardening": VonMises(**SOIL, yield_stress=2e4, hardening_modulus=3e6),
    "DP sand": DruckerPrager(**SOIL, friction_angle=37.0),
    "DP dilating": DruckerPrager(**SOIL, friction_angle=30.0, dilation_angle=12.0, cone="plane_strain"),
    "DP cohesive": DruckerPrager(**SOIL, friction_angle=30.0, dilation_angle=10.0, cohesion=1e4),
    "DP softening": DruckerPrager(
        **SOIL, friction_angle=30.0, dilation_angle=5.0, cohesion=2e4, softening_strain=0.01, cone="triaxial_extension"
    ),
    "softening cone": SofteningCone(
        **SOIL, friction_angle=37.0, residual_friction_angle=30.0, dilation_angle=10.0, softening_strain=0.05,
        dilation_strain=0.03,
    ),
    "softening cone, cohesive": SofteningCone(
        **SOIL, friction_angle=30.0, residual_friction_angle=20.0, dilation_angle=5.0, cohesion=2e4,
        residual_cohesion=2e3, softening_strain=0.02, cone="plane_strain",
    ),
    "MC sand": MohrCoulomb(**SOIL, friction_angle=37.0),
    "MC cohesive": MohrCoulomb(**SOIL, friction_angle=30.0, dilation_angle=10.0, cohesion=1e4),
    "MC associated": MohrCoulomb(**SOIL, friction_angle=25.0, dilation_angle=25.0, cohesion=1e4),
    "Tresca": MohrCoulomb(**SOIL, friction_angle=0.0, cohesion=1e4),
    "mu(I)": MuI(**SOIL, static_friction=0.38, limit_friction=0.64, grain_diameter=1e-3, grain_density=2500.0),
    "mu(I), phi(I)": MuPhiI(**SOIL, static_friction=0.38, limit_friction=0.64, grain_diameter=1e-3,
                            grain_density=2600.0),
}
COUNT = 4000


@dataclass(frozen=True)
class Steps:
    """COUNT steps: h (n, 3, 3) and state before, increment A, trial Hencky strain (n, 3, 3), result."""

    law: object
    h: np.ndarray
    state: np.ndarray
    A: np.ndarray
    trial: np.ndarray
    result: Updated

    def stress(self):
        return unpack(self.result.stress.astype(float))

    def plastic(self):
        """Plastic Hencky strain of the step; for material that was not separated before it."""
        return self.trial - self.law.hencky_from_stress(self.stress())


def rotations(n, dimension, rng):
    if dimension == 3:
        return random_rotations(n, rng)
    angle = rng.uniform(0.0, 2.0 * np.pi, n)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]).transpose(2, 0, 1)


def stretches(n, size, dimension, rng):
    """f − I of random stretches of up to exp(size) between random rotations; a third of them nearly isotropic."""
    directions = rng.uniform(-1.0, 1.0, (n, dimension))
    directions[: n // 3] = 0.2 * directions[: n // 3] + directions[: n // 3, :1]
    U, V = rotations(n, dimension, rng), rotations(n, dimension, rng)
    return np.einsum("nij,nj,nkj->nik", U, np.exp(size * directions), V) - np.eye(dimension)


def hencky(b):
    values, vectors = np.linalg.eigh(b)
    return np.einsum("nij,nj,nkj->nik", vectors, 0.5 * np.log(np.maximum(values, 1e-300)), vectors)


@functools.cache
def random_steps(name, size, dimension=3, precision="f64", dt=1e-3):
    """A step of the given size from what an earlier random step of 1 % left: on the surface, inside, or separated.

    Inputs are numbers of float32, the same for both precisions.
    """
    law, rng = LAWS[name], np.random.default_rng(3)
    double = StressUpdate(law, dimension, "f64")
    squeeze = np.exp(-rng.uniform(0.0, 0.02, COUNT))[:, None, None] * np.eye(dimension) - np.eye(dimension)
    before = double(np.zeros((COUNT, 6 if dimension == 3 else 4)), double.initial_state(COUNT), squeeze, dt)
    before = double(before.h, before.state, stretches(COUNT, 0.01, dimension, rng), dt)
    h, state = (a.astype(np.float32).astype(float) for a in (before.h, before.state))
    A = stretches(COUNT, size, dimension, rng).astype(np.float32).astype(float)
    f = np.tile(np.eye(3), (COUNT, 1, 1))
    f[:, :dimension, :dimension] += A
    trial = hencky(f @ (np.eye(3) + unpack(h)) @ f.transpose(0, 2, 1))
    return Steps(law, unpack(h), state, A, trial, StressUpdate(law, dimension, precision)(h, state, A, dt))


def stress_of(law, strain):
    """Kirchhoff stress (..., 3, 3) of an elastic Hencky strain."""
    volume = np.trace(strain, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    return 2.0 * law.shear_modulus * (strain - volume / 3.0) + law.bulk_modulus * volume

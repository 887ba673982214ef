"""A granular slab that slides off over its own grains (M15).

Without dilation, steady shear leaves s_xx = s_yy = 0, so that a Drucker-Prager slab on rough ground carries
tau / sigma_n = alpha / sqrt(3), which is sin(phi), not tan(phi), on the cone that meets Mohr-Coulomb in plane strain:

    a = g (sin θ - alpha / sqrt(3) cos θ),  whatever the thickness of the band that shears.

H = 0.4 m; E = 1e6 Pa, nu = 0.3, rho = 1500 kg/m3; it starts in the pressure rho g cos θ (H - y).
"""

import numpy as np

from snowmpm.materials import DruckerPrager
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice

G, STEEP = 9.81, np.radians(35.0)


def slab(law, scheme, depth, cells, slope, gravity, offset=0.0, per_axis=2, **state):
    """A slab on rough ground `offset` cells above a node, eight cells of it, periodic along the slope."""
    dx = depth / cells
    positions, volumes = lattice([0.0, 0.0], [8 * dx, depth], dx, per_axis)
    base = np.array([0.0, offset * dx])
    return scheme.solver(Population(positions + base, volumes, 0, **state), [law], dx=dx, origin=np.zeros(2),
                         lower=base, upper=np.array([8 * dx, 2 * depth]),
                         gravity=gravity * np.array([np.sin(slope), -np.cos(slope)]),
                         sides=[["periodic", "periodic"], ["stick", "open"]])


def pressed(law, height, depth, slope):
    """Stress and elastic state of particles in the pressure of what lies above them, and their volume ratio."""
    pressure = law.density * G * np.cos(slope) * (depth - height)
    isotropic = np.array([1.0, 1.0, 1.0, 0.0])
    if law.STORED == "stress":
        stress = -pressure[:, None] * isotropic
        return dict(elastic=stress, stress=stress), np.ones(len(pressure))
    strain = -pressure / (3.0 * law.bulk_modulus)
    return dict(elastic=np.expm1(2.0 * strain)[:, None] * isotropic,
                stress=-pressure[:, None] * isotropic), np.exp(3.0 * strain)


def pressed_slab(law, scheme, cells, offset=0.0, slope=STEEP, depth=0.4, per_axis=2):
    """-> solver of a `slab` in the pressure of its weight, volume ratios and heights [m] of its particles."""
    height = lattice([0.0, 0.0], [8 * depth / cells, depth], depth / cells, per_axis)[0][:, 1]
    state, volume_ratio = pressed(law, height, depth, slope)
    return slab(law, scheme, depth, cells, slope, G, offset, per_axis, **state), volume_ratio, height


def granular(friction_angle):
    """A granular law; friction_angle [rad]."""
    return DruckerPrager(density=1500.0, youngs_modulus=1e6, poisson_ratio=0.3, cone="plane_strain",
                         friction_angle=float(np.degrees(friction_angle)))


def gained(solver, volume_ratio, chosen, down):
    """Acceleration of the chosen particles along `down` from 0.15 to 0.4 s [m/s2]."""
    states, rows = ParticleStates(solver), []
    states.set(volume_ratio=volume_ratio)
    while solver.time < 0.4:
        for _ in range(10):
            solver.step(solver.stable_dt()[0])
        rows.append((solver.time, (states.column("velocity")[chosen] @ down).mean()))
    time, speed = np.array(rows).T
    return np.polyfit(time[time > 0.15], speed[time > 0.15], 1)[0]


def exact_acceleration(sine, slope=STEEP):
    """g (sin θ - sin φ cos θ) [m/s2]."""
    return G * (np.sin(slope) - sine * np.cos(slope))


def acceleration(friction_angle, scheme, cells=20, offset=0.0, slope=STEEP, depth=0.4, per_axis=2):
    """Of the upper tenth of a granular slab [m/s2]; friction_angle [rad]."""
    return acceleration_of(granular(friction_angle), scheme, cells, offset, slope, depth, per_axis)


def acceleration_of(law, scheme, cells=20, offset=0.0, slope=STEEP, depth=0.4, per_axis=2):
    """Of the upper tenth of a slab of a law [m/s2]."""
    solver, volume_ratio, height = pressed_slab(law, scheme, cells, offset, slope, depth, per_axis)
    return gained(solver, volume_ratio, height > 0.9 * depth, np.array([1.0, 0.0]))

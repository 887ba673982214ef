"""Propagation saw test with an elastic weak layer (S1): energy release rate and deflection of the free end.

Slab 250 kg/m3, 0.5 m, 3 MPa; weak layer 50 mm, 0.5 MPa; both nu = 0.3, plane strain. The cut is there from the start.
The slab starts in the state of an infinite slope and is brought to rest, critically damped. The energy release rate is
the difference of the potential energy of two cuts, -dPi/da.

WEAC (Rosendahl & Weissgraeber 2020, doi:10.5194/tc-14-115-2020) is a Timoshenko beam on an elastic layer, solved in
closed form. It takes the weak layer for springs, k_n = E / (1 - nu^2) t and k_t = G / t. A real layer between slab and
ground cannot widen: its k_n is that of oedometric compression, 23 % more at nu = 0.3 (in WEAC: 7 % less deflection).
Here it has the E and nu whose oedometric modulus and G are WEAC's: nu' = nu / (1 + nu), E' = E (1 + nu') / (1 + nu).
"""

import numpy as np

from snowmpm.materials import Elastic

CUTS = (0.3, 0.5)  # m
LENGTH = 2.0  # m; WEAC says that 6 m change nothing
BONDED = 0.3 / 1.3
WEAK_LAYER = {"kind": "elastic", "density": 100.0, "youngs_modulus": 0.5e6 * (1.0 + BONDED) / 1.3,
              "poisson_ratio": BONDED}
NORMAL_STIFFNESS = 0.5e6 / 0.91 / 0.05  # Pa/m, of WEAC: plane strain, E / (1 - nu^2) / t
SLAB = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
SLAB_HEIGHT = 0.5  # m
FLAT = (1.865973, 2.437954)
"""On the flat: mean energy release rate between the CUTS [J/m2], and deflection over the longer one [mm], by WEAC."""


def at_rest(scheme, cut, slope_angle, dx, per_axis=2):
    """Potential energy Pi [J/m] and deflection of the free end [mm], from the state of an infinite slope."""
    simulation = scheme.simulation("pst_2d", dx, per_axis, {
        "materials.weak_layer": WEAK_LAYER, "initial.stress": "geostatic",
        "saw_test.length": LENGTH, "saw_test.notch": cut, "saw_test.saw_length": cut,
        "saw_test.slope_angle": slope_angle, "saw_test.weak_layer": {"material": "weak_layer", "thickness": 0.05}})
    solver = simulation.solver
    # First frequency of the free end, which reaches about 0.3 m into the weak layer
    omega = 3.516 * np.sqrt(3e6 / 0.91 * 0.5**2 / 12.0 / 250.0) / (cut + 0.3) ** 2
    while solver.time < 12.0 / omega:
        dt, _ = solver.stable_dt()
        solver.keep = 1.0 - 2.0 * omega * dt
        simulation.step()
    particles = simulation.particles
    moved = particles["position"] - simulation.model.population.positions[particles["id"]]
    elastic = solver.materials.elastic_energy(particles["material"], particles.kirchhoff(), particles.state(),
                                              particles["volume"] / particles["J"])
    settled = simulation.crack.values()["settlement"][-1].astype(float)
    end = 1.5 * settled[0] - 0.5 * settled[1]  # from the middle of the first bin to its edge
    return elastic - float(particles["mass"] @ (moved @ solver.gravity)), 1e3 * end


def settlement(slope_angle):
    """Of the slab on the springs of WEAC [mm], which its deflection contains."""
    return 1e3 * SLAB.density * 9.81 * SLAB_HEIGHT * np.cos(np.radians(slope_angle)) / NORMAL_STIFFNESS


def flat_error(scheme, cells, per_axis=2):
    """Root mean square of the relative errors against `FLAT`; cells: in the height of the slab."""
    (before, _), (after, end) = (at_rest(scheme, cut, 0.0, SLAB_HEIGHT / cells, per_axis) for cut in CUTS)
    found = (before - after) / (CUTS[1] - CUTS[0]), end + settlement(0.0)
    return np.sqrt(np.mean((np.array(found) / FLAT - 1.0) ** 2))

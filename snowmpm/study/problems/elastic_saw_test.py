"""Propagation saw test with an elastic weak layer (S1): energy release rate and deflection of the free end.

Slab 250 kg/m3, 0.5 m, 3 MPa; weak layer 50 mm, 0.5 MPa; both nu = 0.3, plane strain. The cut is there from the start.
The slab starts in the state of an infinite slope and is brought to rest. The energy release rate is the difference of
the potential energy of two cuts, -dPi/da.

WEAC (Rosendahl & Weissgraeber 2020, doi:10.5194/tc-14-115-2020) is a Timoshenko beam on springs, k_n = E / (1 - nu^2) t
and k_t = G / t. A real layer between slab and ground cannot widen: its k_n is that of oedometric compression, 23 % more
at nu = 0.3 (in WEAC: 7 % less deflection). Here it has the E and nu whose oedometric modulus and G are WEAC's:
nu' = nu / (1 + nu), E' = E (1 + nu') / (1 + nu). The answer is that of finite elements of the same layers, which is
within 3 % of WEAC's.
"""

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.materials import Elastic

CUTS = (0.3, 0.5)  # m
LENGTH = 2.0  # m; WEAC says that 6 m change nothing
BONDED = 0.3 / 1.3
WEAK_LAYER = {"kind": "elastic", "density": 100.0, "youngs_modulus": 0.5e6 * (1.0 + BONDED) / 1.3,
              "poisson_ratio": BONDED}
SLAB = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)
SLAB_HEIGHT = 0.5  # m
FLAT = (1.91592, 2.37373e-3)
"""On the flat, by finite elements a quarter of the weak layer wide: energy release rate between the CUTS [J/m2], and
deflection over the longer one [m]."""


def at_rest(scheme, cut, slope_angle, dx, per_axis=2):
    """Potential energy Pi [J/m] and deflection of the free end [m], from the state of an infinite slope."""
    simulation = scheme.simulation("pst_2d", dx, per_axis, {
        "materials.weak_layer": WEAK_LAYER, "initial.stress": "geostatic",
        "saw_test.length": LENGTH, "saw_test.notch": cut, "saw_test.saw_length": cut,
        "saw_test.slope_angle": slope_angle, "saw_test.ends": "normal",
        "saw_test.weak_layer": {"material": "weak_layer", "thickness": 0.05}})
    solver = simulation.solver
    # First frequency of a beam clamped 0.3 m beyond the cut; 0.6 of it with the shear of so short a beam (measured)
    omega = 0.6 * 3.516 * np.sqrt(3e6 / 0.91 * 0.5**2 / 12.0 / 250.0) / (cut + 0.3) ** 2
    peak, kinetic = 0.0, np.inf
    while solver.time < 3.0 / omega or kinetic > 1e-6 * peak:
        dt, _ = solver.stable_dt()
        solver.damping_factor = 1.0 - 2.0 * omega * dt
        simulation.step()
        if solver.steps % 50 == 0:
            kinetic = float(solver.particles.masses() @ (solver.particles.column("velocity") ** 2).sum(axis=1))
            peak = max(peak, kinetic)
        if solver.time > 60.0 / omega:
            raise SimulationError(f"does not come to rest in {solver.time:.3g} s")
    particles = simulation.particles
    moved = particles["position"] - simulation.model.population.positions[particles["id"]]
    elastic = solver.materials.elastic_energy(particles["material"], particles.kirchhoff(), particles.state(),
                                              particles["volume"] / particles["J"])
    settled = simulation.crack.values()["settlement"][-1].astype(float)
    end = 1.5 * settled[0] - 0.5 * settled[1]  # from the middle of the first bin to its edge
    return elastic - float(particles["mass"] @ (moved @ solver.gravity)), end


def flat_error(scheme, cells, per_axis=2):
    """Root mean square of the relative errors against `FLAT`; cells: in the height of the slab."""
    (before, _), (after, end) = (at_rest(scheme, cut, 0.0, SLAB_HEIGHT / cells, per_axis) for cut in CUTS)
    found = (before - after) / (CUTS[1] - CUTS[0]), end
    return np.sqrt(np.mean((np.array(found) / FLAT - 1.0) ** 2))

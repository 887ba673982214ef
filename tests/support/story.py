"""How a slab is released, told from moment to moment.

A crack is weak layer that has lost all its bonds (damage 1); its front the outermost of it, without the last hundredth.
"""

import numpy as np

import snowmpm

GRAVITY = 9.81
COLLAPSED = 0.99


class Story:
    """A scene run from moment to moment, particles in the order of their numbers."""

    def __init__(self, name, **overrides):
        self.simulation = snowmpm.Simulation(snowmpm.load_scene(name, overrides))
        self.simulation.solver.time = 0.0  # the rest before the trigger is computed here, and looked at
        self.materials = list(self.simulation.scene.materials)
        first = self._sorted()
        self.home, material = first["position"], first["material"]
        self.weak, self.slab = (material == self.materials.index(name) for name in ("weak_layer", "slab"))
        self.fastest = 0.0

    def _sorted(self):
        particles = self.simulation.particles
        order = np.argsort(particles["id"])
        return {name: particles[name][order] for name in ("position", "velocity", "damage", "material")}

    def at(self, time):
        """Positions, velocities, damage and displacements at a time [s]; `fastest` [m/s] since the last one."""
        self.fastest = 0.0
        while self.simulation.time < time - 1e-9:
            self.simulation.step(until=time)
            self.fastest = max(self.fastest, self.simulation.max_speed)
        now = self._sorted()
        now["moved"] = now["position"] - self.home
        return now

    def crack(self, now):
        """x of the lower and upper end of the crack [m], and its share of the weak layer."""
        broken = now["position"][self.weak & (now["damage"] > COLLAPSED), 0]
        if not len(broken):
            return np.nan, np.nan, 0.0
        return *np.quantile(broken, [0.005, 0.995]), len(broken) / self.weak.sum()

    def crown(self, now, apart=0.1):
        """x on the slope, before the release, of the uppermost slab that has moved by `apart` [m]."""
        return self.home[self.slab & (np.linalg.norm(now["moved"], axis=1) > apart), 0].min()

    def audit_is_clean(self):
        audit = self.simulation.audit()
        return audit["unconverged"] == 0 and audit["momentum_residual"] < 1e-5


def at_rest(speed, depth):
    """Whether a speed [m/s] is below 1 % of sqrt(g D)."""
    return speed < 0.01 * np.sqrt(GRAVITY * depth)

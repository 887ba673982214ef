"""How a problem with a known answer is solved: transfer, spline, gradient, precision, time step; and its solver."""

from dataclasses import dataclass, replace

import numpy as np

from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.scenes.numerics import Sph
from snowmpm.schemes import TRANSFERS
from snowmpm.sph.courant import critical_cfl as critical_sph_cfl
from snowmpm.sph.courant import usual_cfl as usual_sph_cfl
from snowmpm.sph.solver import SphSolver
from snowmpm.stepping.time_step import critical_cfl, grain_stiffness, usual_cfl


@dataclass(frozen=True)
class Scheme:
    """A transfer on a basis; flip_ratio: share of FLIP in "flip" and "aflip"; cfl: the usual one when None.

    method: "mpm" or "sph", of which the rest says nothing but precision and cfl."""

    transfer: str
    flip_ratio: float = 0.97
    kernel: str = "quadratic"
    gradient: str = "affine"
    precision: str = "f64"
    cfl: float | None = None
    method: str = "mpm"

    @property
    def options(self):
        """Arguments of `MpmSolver`, but for precision and step."""
        return {"transfer": self.transfer, "flip_ratio": self.flip_ratio, "kernel": self.kernel,
                "gradient": self.gradient}

    def solver(self, population, laws, **options):
        """`MpmSolver` of this scheme, or `SphSolver` of particles that fill a regular lattice."""
        if self.method == "sph":
            dim = population.positions.shape[1]
            spacing = float(population.volumes.mean()) ** (1.0 / dim)
            return SphSolver(population, laws, precision=self.precision, cfl=self.cfl, scheme=Sph(),
                             **{**options, "dx": spacing})
        return MpmSolver(population, laws, precision=self.precision, cfl=self.cfl, **self.options, **options)

    def simulation(self, scene, dx, per_axis=2, overrides=None):
        """`Simulation` of a library scene with this scheme."""
        from snowmpm.running.simulation import Simulation
        from snowmpm.scenes import load_scene

        dim = load_scene(scene).dimension
        if self.method == "sph":
            chosen = {"solver.method": "sph", "solver.dx": dx / per_axis, "solver.precision": self.precision}
            return Simulation(load_scene(scene, chosen | (overrides or {})))
        chosen = {f"solver.{name}": value for name, value in self.options.items()}
        chosen |= {"solver.dx": dx, "solver.precision": self.precision, "solver.particles_per_cell": per_axis**dim}
        if self.cfl:
            chosen["solver.cfl"] = self.cfl
        return Simulation(load_scene(scene, chosen | (overrides or {})))

    def courant(self, law, dim):
        """Longest C of its steps: its cfl, or that of a scene without one."""
        if self.cfl is not None:
            return self.cfl
        if self.method == "sph":
            return usual_sph_cfl(critical_sph_cfl(Sph().viscosity, Sph().disorder_damping))
        return usual_cfl(critical_cfl(self.kernel, self.gradient, self.transfer, grain_stiffness(law, dim)))

    @property
    def affine(self):
        """Whether particles hand their velocity gradient on."""
        return self.method == "mpm" and TRANSFERS[self.transfer].affine

    def __str__(self):
        if self.method == "sph":
            return "sph"
        ratio = f"-{self.flip_ratio:g}" if "flip" in self.transfer else ""
        shape = "-shape" if self.gradient == "shape" else ""
        return f"{self.kernel}-{self.transfer}{ratio}{shape}"


APIC, PIC = Scheme("apic"), Scheme("pic")
FLIP, AFLIP = Scheme("flip", 0.99), Scheme("aflip", 0.99)
QUADRATIC = [APIC, PIC, FLIP, AFLIP]
CLASSICAL = Scheme("flip", 0.99, "cubic", "shape")
"""The algorithm of the snow chapter: cubic splines, gradient of the shape functions, PIC and FLIP."""
CUBIC = [*(replace(scheme, kernel="cubic") for scheme in QUADRATIC), CLASSICAL]
EVERY = [replace(scheme, kernel=kernel, gradient=gradient) for kernel in ("quadratic", "cubic")
         for gradient in ("affine", "shape") for scheme in QUADRATIC]


def free_solver(positions, volumes, laws, scheme, dx, *, material=0, velocities=None, gravity=None, reach=None,
                **options):
    """Solver of a body with nothing around it within `reach` [m] (30 of its cells by default).

    laws: one, or a list of those that `material` counts.
    """
    dim, laws = positions.shape[1], laws if isinstance(laws, list) else [laws]
    reach = 30.0 * dx if reach is None else reach
    lower, upper = positions.min(axis=0) - reach, positions.max(axis=0) + reach
    origin = dx * np.floor(lower / dx)
    return scheme.solver(Population(positions, volumes, material, velocities), laws, dx=dx, origin=origin, lower=lower,
                         upper=upper, gravity=np.zeros(dim) if gravity is None else gravity, **options)


def lattice(lower, upper, dx, per_axis=2):
    """Regular particles of a box: positions (n, dim) [m] and volumes (n,)."""
    counts = [round((hi - lo) / dx * per_axis) for lo, hi in zip(lower, upper, strict=True)]
    axes = [lo + (np.arange(n) + 0.5) * (hi - lo) / n for lo, hi, n in zip(lower, upper, counts, strict=True)]
    positions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    return positions, np.full(len(positions), float(np.prod([a[1] - a[0] if len(a) > 1 else dx / per_axis
                                                             for a in axes])))

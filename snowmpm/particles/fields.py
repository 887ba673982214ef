"""Particle fields by name, as output, diagnostics and users read them: NumPy copies in SI units."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from snowmpm.annotations import Floats, Numbers
from snowmpm.materials import LAWS, unpack
from snowmpm.particles.contract import Particles
from snowmpm.particles.regimes import DENSEST, LOOSEST, inertial_number, regime, steady_fraction, strain_rate
from snowmpm.registry import FIELDS, Registry

if TYPE_CHECKING:
    from snowmpm.particles.material_table import MaterialTable
    from snowmpm.particles.snapshot import Snapshot


@dataclass(frozen=True)
class ParticleField:
    """A field of every particle, whatever its law. unit: in SI, "1" without; reads: given a `ParticleFields`, returns
    its values (n,) or (n, columns); description: what it is, in a line."""

    REGISTRIES: ClassVar[tuple[Registry, ...]] = (FIELDS,)

    name: str
    unit: str
    reads: Callable[["ParticleFields"], Numbers]
    description: str = ""


def of_laws() -> dict[str, str]:
    """Units of what laws report of their state, by name."""
    return {name: unit.replace("-", "1") for law in LAWS.values() for name, unit in law.OUTPUTS.items()}


def field_units() -> dict[str, str]:
    """Unit of every field, by name."""
    return {**{name: field.unit for name, field in FIELDS.items()}, **of_laws()}


class ParticleFields:
    """`fields[name]`: one array a name, (n,) or (n, columns), copied when asked for; one table copy serves all names.

    DESCRIPTIONS says what each is. stress: (n, 6), effective with water. What the laws report of their state (their
    OUTPUTS: p0, damage, plastic_strain, gap ...) is zero where a law has no such thing.
    """

    materials: "MaterialTable"
    snapshot: "Snapshot"
    sizes: dict[str, int]
    """numbers that a particle carries, by the name of their column"""

    def __init__(self, particles: Particles, body_starts: ArrayLike = (0,)) -> None:
        """particles: a `particles.contract.Particles`; body_starts: first particle number of each body."""
        self.materials = particles.materials
        self.snapshot = particles.snapshot()
        self.sizes = particles.sizes
        self._constants = particles.constants
        self._body_starts, self._bodies = np.asarray(body_starts), particles.bodies
        self._still = particles.still_column

    def __repr__(self) -> str:
        return f"ParticleFields({len(self.snapshot.labels)} particles: {', '.join(sorted(field_units()))})"

    def __getitem__(self, name: str) -> Numbers:
        """Raises KeyError for a name that nothing reads."""
        if name in FIELDS:
            return FIELDS[name].reads(self)
        if name in of_laws():
            return self._of_laws(name)
        raise KeyError(f"no particle field {name!r}; there are {', '.join(sorted({*FIELDS, *of_laws()}))}")

    def __contains__(self, name: object) -> bool:
        return name in field_units()

    def __iter__(self) -> Iterator[str]:
        return iter(field_units())

    def column(self, name: str) -> Floats:
        """One column of the store, float64, (n, size)."""
        return self.snapshot.column(name)

    def kirchhoff(self) -> Floats:
        """Kirchhoff stress (n, 6) [Pa]."""
        tau = self.column("stress")
        return tau if tau.shape[1] == 6 else np.pad(tau, ((0, 0), (0, 2)))

    def velocity_gradient(self) -> Floats:
        """grad v (n, dim * dim) [1/s], row major: the affine part of a particle's motion."""
        return self.column("affine")

    def water(self) -> Floats:
        """Column "water" (n, at least 3): mass per reference volume [kg/m3], pressure [Pa], volume of the grains per
        reference volume [-]; zero without water."""
        if "water" not in self.sizes:
            return np.zeros((len(self.snapshot.labels), 3))
        return self.column("water")

    def constant(self, name: str) -> float:
        """A number of a component, 1 without one of this name."""
        return self._constants.get(name, 1.0)

    def excess_pressure(self) -> Floats:
        """Column "excess_pressure" (n,) [Pa]; zero for particles without one."""
        held = "excess_pressure" in self.sizes
        return self.column("excess_pressure")[:, 0] if held else np.zeros(len(self.snapshot.labels))

    def reference_density(self) -> Floats:
        """Mass per reference volume [kg/m3], water included, (n,)."""
        return self.materials.density[self["material"]] + self.water()[:, 0]

    def flowing(self) -> NDArray[np.bool_] | slice:
        """Which particles (n,) are part of the flow: all, as a slice that copies nothing, or all but those that lie as
        they were laid."""
        if not self._still:
            return slice(None)
        return self.column(self._still)[:, 0] <= 0.0

    def state(self) -> Floats:
        """State of the law of each particle (n, largest number of state variables)."""
        return self.column("state")

    def bodies(self) -> NDArray[np.intp]:
        """Index of the body of each particle (n,)."""
        if self._bodies is not None:
            return self._bodies[self["id"]]
        return np.searchsorted(self._body_starts, self["id"], side="right") - 1

    def _of_laws(self, name: str) -> Floats:
        material, values = self["material"], np.zeros(len(self.snapshot.labels))
        for m, law in enumerate(self.materials.laws):
            own = material == m
            state = self.state()[own]
            values[own] = law.outputs(state[:, : len(law.STATE)]).get(name, 0.0)
        return values


PORE_PRESSURE, GRAINS = 1, 2
"""Entries of the column "water" (`water.particle_kernels`)."""

def _share(part, whole):
    return np.divide(part, whole, out=np.zeros(len(part)), where=whole > 0.0)


def _liquid_water(fields):
    return fields.water()[:, 0] / fields.constant("water_density") / fields["J"]


def _stress(fields):
    return fields.kirchhoff() / fields["J"][:, None]


def _q(fields):
    sigma = _stress(fields)
    s = sigma[:, :3] - sigma[:, :3].mean(axis=1, keepdims=True)
    return np.sqrt(1.5 * (s**2).sum(axis=1) + 3.0 * (sigma[:, 3:] ** 2).sum(axis=1))


def _of_grains(fields):
    """grain_diameter [m] and grain_density [kg/m3] of the law of each particle, 0 where it names none (n, 2)."""
    numbers = [[law.get(name) or 0.0 for name in ("grain_diameter", "grain_density")]
               for law in fields.materials.laws]
    return np.array(numbers)[fields["material"]]


def _inertial_number(fields):
    diameter, density = _of_grains(fields).T
    return inertial_number(fields["strain_rate"], fields["p"], diameter, density)


def _steady_fraction(fields):
    numbers = [[law.get(name, of_beads) for name, of_beads in (("densest_fraction", DENSEST),
                                                                    ("loosest_fraction", LOOSEST))]
               for law in fields.materials.laws]
    number = fields["inertial_number"]
    found = steady_fraction(number, *np.array(numbers)[fields["material"]].T)
    return np.where(number > 0.0, found, 0.0)


def _failure_function(fields):
    material, values = fields["material"], np.zeros(len(fields.snapshot.labels))
    stress, state = unpack(fields.kirchhoff()), fields.state()
    for m, law in enumerate(fields.materials.laws):
        own = material == m
        if law.failure_function is not None and own.any():
            values[own] = law.failure_function(stress[own], state[own, : len(law.STATE)])
    return values


DESCRIPTIONS = {
    "position": "of the particle, from the run's origin",
    "velocity": "of the particle",
    "density": "current density, with the water in the pores",
    "mass": "of the particle, with its water; per metre of width in 2-D",
    "volume": "current volume; an area in 2-D",
    "stress": "Cauchy stress, 6 components xx, yy, zz, xy, yz, xz of the tensor axes, tension positive; in 2-D axis "
        "0 is x, 1 is z, 2 is out of plane; effective with water",
    "p": "pressure, -tr(stress)/3: positive in compression",
    "q": "equivalent shear stress, sqrt(3/2 s:s) of the deviator s",
    "J": "volume over that at the start, det F",
    "material": "index of the material in the scene",
    "body": "index of the body in the scene",
    "id": "number given at seeding: follows a particle from frame to frame",
    "depth": "thickness of the snow normal to the ground, of the columns of a depth-averaged flow; else 0",
    "pore_pressure": "of the water in the pores, of columns that at the ground; 0 without water",
    "porosity": "volume of the pores over that of the snow; 0 without water",
    "saturation": "volume of water over that of the pores; 0 without water",
    "liquid_water": "volume of water over that of the snow; 0 without water",
    "excess_pressure": "what the pore pressure of a column exceeds the hydrostatic one by; else 0",
    "strain_rate": "sqrt(2 D':D') of the deviator D' of the rate of deformation",
    "inertial_number": "I of the strain rate, the pressure and the grains of the law (grain_diameter, grain_density); "
        "0 where there are none or none press",
    "flow_regime": "by the inertial number: 0 none, 1 quasi-static, 2 dense, 3 collisional",
    "steady_solid_fraction": "phi(I) of steady flow; 0 where flow_regime is",
    "failure_function": "of a law in rate form: above 0 where some stretching leaves the stress as it is, -1 without "
        "stress; 0 for other laws",
}
"""What each field of the program is."""

for field in (
    ParticleField("position", "m", lambda fields: fields.snapshot.positions()),
    ParticleField("velocity", "m/s", lambda fields: fields.column("velocity")),
    ParticleField("density", "kg/m3", lambda fields: fields.reference_density() / fields["J"]),
    ParticleField("mass", "kg", lambda fields: fields.column("volume")[:, 0] * fields.reference_density()),
    ParticleField("volume", "m3", lambda fields: fields.column("volume")[:, 0] * fields["J"]),
    ParticleField("stress", "Pa", _stress),
    ParticleField("p", "Pa", lambda fields: -_stress(fields)[:, :3].mean(axis=1)),
    ParticleField("q", "Pa", _q),
    ParticleField("J", "1", lambda fields: fields.column("volume_ratio")[:, 0]),
    ParticleField("material", "1", lambda fields: fields.snapshot.labels[:, 0]),
    ParticleField("body", "1", ParticleFields.bodies),
    ParticleField("id", "1", lambda fields: fields.snapshot.labels[:, 1]),
    ParticleField("depth", "m", lambda fields: fields.snapshot.depth()),
    ParticleField("pore_pressure", "Pa", lambda fields: fields.water()[:, PORE_PRESSURE]),
    ParticleField("porosity", "1", lambda fields: np.where((fields.water()[:, [0, GRAINS]] > 0.0).any(axis=1),
                                                           1.0 - fields.water()[:, GRAINS] / fields["J"], 0.0)),
    ParticleField("saturation", "1", lambda fields: _share(fields["liquid_water"], fields["porosity"])),
    ParticleField("liquid_water", "1", _liquid_water),
    ParticleField("excess_pressure", "Pa", ParticleFields.excess_pressure),
    ParticleField("strain_rate", "1/s", lambda fields: strain_rate(fields.velocity_gradient())),
    ParticleField("inertial_number", "1", _inertial_number),
    ParticleField("flow_regime", "1", lambda fields: regime(fields["inertial_number"])),
    ParticleField("steady_solid_fraction", "1", _steady_fraction),
    ParticleField("failure_function", "1", _failure_function),
):
    FIELDS.add(replace(field, description=DESCRIPTIONS[field.name]))

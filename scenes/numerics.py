"""Method, domain and output of a scene."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from snowmpm import components
from snowmpm.materials import LAWS
from snowmpm.methods import METHODS
from snowmpm.registry import FIELDS
from snowmpm.scenes.shapes import check_corners
from snowmpm.scenes.space import AXES, NUMBER, TABLE, TEXT, Vector, by_type, dimension
from snowmpm.scenes.spec import Fraction, NonNegative, Number, Positive, Spec, one_of, refuse
from snowmpm.schemes import BASES, GRADIENTS, TRANSFERS, misfit

Boundary = Literal["open", "slip", "symmetric", "stick", "separate", "periodic"]


def field_names():
    """Fields that a frame may hold besides the position: those of every particle, and outputs of laws."""
    return [name for name in FIELDS if name != "position"] + sorted({n for law in LAWS.values() for n in law.OUTPUTS})


class Output(Spec):
    """Content of the run file, and intervals."""

    EXAMPLES: ClassVar = {"checkpoint_interval": 60.0, "map_cell": 5.0}

    interval: Positive = 0.05
    """time between frames [s]"""
    fields: tuple[Annotated[str, one_of(field_names)], ...] = ("velocity", "density")
    """particle fields of each frame, besides the position"""
    checkpoint_interval: Positive | None = None
    """time between checkpoints [s]; about every two minutes of wall time when missing"""
    map_cell: Positive | None = None
    """side of a plan cell of the maps of a 3-D run [m]: a whole multiple, or a whole fraction, of an elevation raster's
    cells. When missing: the smallest multiple that is two grid spacings wide and holds 24 particles at the flow depth,
    a tenth of the release depth; without a raster, that width rounded up to two digits"""

    @field_validator("fields")
    @classmethod
    def _once_each(cls, fields):
        for name in fields:
            if fields.count(name) > 1:
                raise refuse(f'names "{name}" twice')
        return fields


class Sph(Spec):
    """Options of the SPH method."""

    kernel: Literal["wendland_c2", "wendland_c4", "wendland_c6", "cubic_spline", "gaussian"] = "wendland_c6"
    """Wendland's kernels of three orders, the cubic spline, or a Gaussian cut off at 3 h"""
    smoothing: Annotated[Number, Field(ge=1.0, le=2.5)] = 1.5
    """smoothing length h over dx [-]; kernels reach 2 h, the Gaussian 3 h; 1.2 gives 3 to 7 % more height in
    the middle of a heap of sand, 1.0 the right stiffness of a thin elastic body; both ring more behind shocks"""
    lengths: Literal["constant", "mean", "harmonic"] = "constant"
    """smoothing lengths that follow the volume of the particles, h (V / dx^d)^(1/d), for flows that disperse; mean,
    harmonic: of the two lengths of a pair, which conserves momentum. Lists of neighbours are up to twice as long"""
    volumes: Literal["follow", "constant"] = "follow"
    """of particles in all sums: follow their deformation, or constant as published with hypoplastic sand, whose law
    knows no density. Not beside variable lengths"""
    gradient: Literal["balanced", "corrected", "plain"] = "balanced"
    """of velocities; balanced: conjugate to the sum of forces, so that volumes follow the density of particles;
    corrected: exact for linear fields, at free surfaces too, but particles crowd in flow; plain: uncorrected kernel
    gradient, which also strains the surface of a rotating body"""
    momentum: Literal["density", "corrected", "volume", "difference"] = "density"
    """form of the momentum equation: density, stresses over squared densities; corrected, the form conjugate to the
    corrected gradient, for thin elastic bodies; volume, for layers of unlike density, between which the form density
    has spurious forces that make a weak layer near its strength yield; difference, only for comparison, since it does
    not conserve momentum and is unstable on irregular particles"""
    viscosity: NonNegative = 0.1
    """alpha of the artificial viscosity [-]: 0.1 is usual for sand; a shock in elastic material then
    overshoots by 40 %. 0.3 overshoots by less than 30 % and lowers heaps by 0.5 %. 1 shortens run-outs"""
    quadratic_viscosity: NonNegative = 0.0
    """beta of the artificial viscosity, quadratic in the closing speed, against interpenetration [-]"""
    disorder_damping: NonNegative = 0.5
    """gamma of a viscosity that acts only on velocity differences beyond a linear field [-]: it keeps particles ordered
    in tension and does not affect smooth motion"""
    walls: Literal["extrapolated", "copied", "most_compressive"] = "extrapolated"
    """stress of the dummy particles in terrain, sides and obstacles: extrapolated from nearby particles; copied from
    the interacting particle; most_compressive: extrapolated, but with the largest nearby pressure on the wall"""
    barrier: Annotated[bool, Field(strict=True)] = True
    """whether walls also stop particles that come within a tenth of dx of them, without rebound"""
    artificial_stress: NonNegative = 0.0
    """epsilon of a repulsion in proportion to tension, against clumping [-]: 0.5 to 0.8, with a viscosity; it does not
    reduce a uniform tension"""
    artificial_stress_power: Annotated[
        Annotated[Number, Field(ge=1.0, le=8.0), NUMBER] | Annotated[Literal["kernel"], TEXT], by_type(NUMBER, TEXT)
    ] = 4.0
    """n of the artificial stress, which falls with the distance as W(r)^n [-]; kernel: W(0) / W(dx), 2.55 of the cubic
    spline at a smoothing of 1.2"""
    artificial_stress_form: Literal["principal", "pressure"] = "principal"
    """principal: along each principal axis in tension; pressure: of the mean tension alone, cheaper in 3-D and weaker,
    with an epsilon of about 0.9"""
    regularisation: Literal["none", "shepard", "mls", "diffusion"] = "none"
    """smoothing of elastic strains, and so of stresses, against noise: mean over neighbours (shepard) or linear fit
    (mls), both every regularisation_interval steps, or diffusion in every step; it blurs layers"""
    regularisation_interval: Annotated[int, Field(strict=True, ge=1)] = 20
    """steps between two smoothings"""
    diffusion: NonNegative = 0.1
    """xi of the diffusion, xi c h grad^2 [-]"""
    confining_pressure: NonNegative = 0.0
    """pressure on free surfaces [Pa]"""
    surface_coverage: Annotated[Number, Field(gt=0.0, le=1.0)] = 1.0
    """the confining pressure acts on particles whose sum of V W over neighbours is below this [-]. 1: on all particles,
    which cancels inside and is exact. 0.55 in 2-D and 0.70 in 3-D select the outermost layer and lose 3 % of the
    pressure there, more if particles are disordered"""

    @model_validator(mode="after")
    def _damped(self):
        if self.artificial_stress > 0.0 and self.viscosity == 0.0:
            raise refuse("needs a viscosity above 0, without which it is unstable", "artificial_stress",
                         self.artificial_stress)
        if self.volumes == "constant" and self.lengths != "constant":
            raise refuse('must be "constant" where volumes are: lengths follow them', "lengths", self.lengths)
        return self


class Depth(Spec):
    """Options of the depth-averaged method."""

    scheme: Literal["columns", "volumes"] = "volumes"
    """volumes: finite volumes on the grid, which hold snow of any depth; columns: particles in plan that carry it. When
    missing, columns for what needs them: snow of several materials, water in a flow, a zone, a method that takes over,
    and the three keys that act on columns: damping, mixing, rim"""
    damping: NonNegative = 0.93
    """C_1 of the rate C_1 c / dx at which neighbours give up differences of velocity that are not linear in place [-]:
    it keeps columns in order"""
    mixing: NonNegative = 17.0
    """C_2 of the same where snow gathers, as at a shock, over -div v [-]"""
    centrifugal: Annotated[bool, Field(strict=True)] = True
    """whether the ground's curvature adds to the normal stress, and so to friction"""
    rim: Annotated[Number, Field(ge=0.0, le=0.5)] = 0.0
    """share of a layer's thickness down to which the front of snow that is let go is resolved, by narrower columns at
    the layer's rims [-]; 0: columns are as wide as elsewhere"""


class Implicit(Spec):
    """Options of implicit MPM: steps that are solved for, far longer than those of a wave."""

    time: Literal["newmark", "quasi_static"] = "newmark"
    """newmark: in time, by the average acceleration; quasi_static: in balance at each step, without inertia. Time then
    only says which loads act"""
    dt: Positive | None = None
    """step [s]; when missing: courant, and for quasi_static a step a frame"""
    courant: Positive = 10.0
    """newmark: cells that an elastic wave crosses in a step [-]"""
    damping: Fraction = 0.0
    """newmark: delta of gamma = 1/2 + delta, beta = (1 + delta)^2 / 4, against swings that the step does not follow
    [-]; 0 keeps the energy and is of second order, above it is of first; 0.3 is chosen beside [water]"""
    tolerance: Annotated[Number, Field(ge=1e-13, le=1e-2)] = 1e-9
    """out-of-balance force over the size of the forces [-] at which a step is solved"""
    iterations: Annotated[int, Field(strict=True, ge=1, le=200)] = 20
    """of Newton at most, before a step is cut in parts"""
    linear: Literal["auto", "direct", "krylov"] = "auto"
    """solver of the linear equations: direct up to 120,000 unknowns in 2-D and 15,000 in 3-D, then by iterations"""


components.open_table("solver.implicit", Implicit)


class Solver(Spec):
    """The method and its discretisation."""

    REMOVED: ClassVar = {"sleeping": (0.0, "was removed, since it seldom saved time (`snowmpm docs speed`);"
                                           ' initial.relaxation = "static" finds snow at rest sooner')}

    method: Annotated[str, one_of(lambda: METHODS)] = "mpm"
    """mpm: material point method; sph: smoothed particle hydrodynamics; depth: depth-averaged flow; implicit: mpm in
    long steps"""
    dx: Positive
    """grid spacing (mpm; in plan: depth) or particle spacing (sph) [m]"""
    kernel: Annotated[str, one_of(lambda: BASES)] = "quadratic"
    """quadratic, cubic: B-splines; gimp, linear: of mpm, for comparison: the linear hat averaged over half a cell, and
    over a sixteenth, both with gradient = "shape" and transfer = "flip" or "pic" """
    gradient: Annotated[str, one_of(lambda: GRADIENTS)] = "affine"
    """affine: forces and velocity gradient by moving least squares; shape: by the gradient of the shape functions (with
    cubic kernel and flip, the classical scheme). affine has the more accurate stress and tears later; shape suits thin
    bodies that bend far, which affine bends too far"""
    transfer: Annotated[str, one_of(lambda: TRANSFERS)] = "apic"
    """errors fall as dx^2 with apic, flip and aflip for every kernel and gradient, with pic at best as dx. The particle
    spacing limits this: at some thousandths of a displacement with 4 particles a cell, at a third of that with 9"""
    flip_ratio: Fraction = 0.97
    """share of FLIP in flip and aflip; the rest is PIC [-]"""
    particles_per_cell: Annotated[int, Field(strict=True, ge=1, le=64)] = Field(
        default_factory=lambda: 4 if dimension() == 2 else 8
    )
    """mpm: particles in a full cell at the start; 4 in 2-D, 8 in 3-D when missing; sph has one particle a cell; depth:
    columns in a cell in plan, 4 when missing"""
    sampling: Literal["regular", "jittered", "poisson"] = "regular"
    """of the particles: on a lattice; displaced from it at random; at random with a least distance"""
    cfl: Annotated[Number, Field(gt=0.0, le=1.0)] | None = None
    """share of a cell that a wave or a particle may cross in a step [-]. When missing, the step follows the state: 0.9
    of the largest stable one, for waves 0.4 while bonds of a weak layer break; 0.3 in sph; in depth 0.5 for waves and
    0.9 for columns"""
    dt: Positive | None = None
    """fixed time step [s]; adaptive when missing"""
    precision: Literal["f32", "f64"] = "f32"
    """of the particles and the grid: single or double"""
    sph: Sph = Field(default_factory=Sph)
    """of method = "sph" """
    depth: Depth = Field(default_factory=Depth)
    """of method = "depth" """
    implicit: Implicit | None = None
    """of method = "implicit"; beside method = "mpm" it makes that implicit"""

    @model_validator(mode="before")
    @classmethod
    def _implicit(cls, given: Any) -> Any:
        """The table makes MPM implicit, which computes in the only precision that it has."""
        if not isinstance(given, dict):
            return given
        if given.get("implicit") is not None and given.get("method", "mpm") == "mpm":
            given = {**given, "method": "implicit"}
        if given.get("method") == "implicit":
            given = {"implicit": {}, "precision": METHODS["implicit"].capabilities.precisions[0], **given}
        return given

    @model_validator(mode="before")
    @classmethod
    def _usual_filling(cls, given: Any) -> Any:
        """With as many particles a cell as its method takes, where the scene does not choose."""
        if isinstance(given, dict) and "particles_per_cell" not in given:
            entry = METHODS.get(str(given.get("method")))
            if entry and entry.capabilities.usual_filling:
                return {**given, "particles_per_cell": entry.capabilities.usual_filling}
        return given

    @model_validator(mode="after")
    def _goes_together(self):
        if found := misfit(self.kernel, self.gradient, self.transfer):
            key, value, allowed = found
            names = " or ".join(f'"{name}"' for name in allowed)
            raise refuse(f'must be {names} beside kernel = "{self.kernel}"', key, value)
        return self

    @property
    def filling(self) -> int:
        """Particles in a full cell at the start."""
        return METHODS[self.method].capabilities.filling or self.particles_per_cell

    def spacing(self, dimension: int) -> float:
        """Mean distance of particles at the start [m], in plan if they are columns."""
        return self.dx / self.filling ** (1.0 / (2 if self.in_plan else dimension))

    @property
    def in_plan(self) -> bool:
        """Whether particles are columns of snow that move in plan."""
        return METHODS[self.method].capabilities.plan

    @property
    def in_volumes(self) -> bool:
        """Whether finite volumes in plan hold the snow."""
        return self.in_plan and self.depth.scheme == "volumes"

    @property
    def adapted(self) -> str:
        """Name of the modules in which components have their adapter for it, and of the rows of its cost."""
        return "volumes" if self.in_volumes else self.method

    @property
    def pieces(self) -> str:
        """What its particles are called."""
        return "cells" if self.in_volumes else METHODS[self.method].particles


components.open_table("solver", Solver)


class Sides(Spec):
    """One boundary a side. open: snow leaves; slip: it slides along; symmetric: the other half mirrors it; stick: it
    does not move; separate: it slides and may lift off; periodic: it comes in again on the other side."""

    x_min: Boundary = "open"
    """side of small x"""
    x_max: Boundary = "open"
    """side of large x"""
    y_min: Boundary = "open"
    """side of small y, 3-D only"""
    y_max: Boundary = "open"
    """side of large y, 3-D only"""
    z_min: Boundary = "open"
    """lower side"""
    z_max: Boundary = "open"
    """upper side"""

    @model_validator(mode="after")
    def _fit_the_scene(self):
        for name in sorted(self.model_fields_set):
            if name[0] not in AXES.get(dimension(), "xyz") and self[name] != "open":
                raise refuse(f"a {dimension()}-D scene has no {name[0]}", name, self[name])
        for axis in "xyz":
            ends = [self[f"{axis}_min"], self[f"{axis}_max"]]
            if ends.count("periodic") == 1:
                one = f"{axis}_min" if ends[0] == "periodic" else f"{axis}_max"
                raise refuse(f"must be periodic at both ends of {axis} or at none", one, "periodic")
        return self


class Domain(Spec):
    """Where matter is followed; by default the bounding box of what the scene can reach."""

    min: Vector | None = None
    """lower corner [m]"""
    max: Vector | None = None
    """upper corner [m]"""
    boundary: Annotated[Annotated[Boundary, TEXT] | Annotated[Sides, TABLE], by_type(TEXT, TABLE)] = "open"

    @model_validator(mode="after")
    def _corners(self):
        if (self.min is None) != (self.max is None):
            raise refuse("needs both min and max, or neither")
        if self.min is not None:
            check_corners(self.min, self.max)
        return self

    def sides(self, dimension: int) -> dict[str, str]:
        """Boundary of each side of a scene of this dimension: {"x_min": "open", ...}."""
        names = [f"{axis}_{end}" for axis in AXES[dimension] for end in ("min", "max")]
        if isinstance(self.boundary, str):
            return dict.fromkeys(names, self.boundary)
        return {name: self.boundary[name] for name in names}

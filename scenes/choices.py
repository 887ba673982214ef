"""Numerical settings that a scene leaves open and the program chooses from its content, with reasons.

Only keys of `[solver]` that the scene does not give are chosen. If a scene gives one key of a group, the whole group
keeps its defaults.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from snowmpm import components
from snowmpm.scenes.depth_scheme import for_columns

if TYPE_CHECKING:
    from snowmpm.scenes.schema import Scene

GRAINS = ("drucker_prager", "mohr_coulomb", "mu_i", "mu_phi_i")
"""Laws of dry grains, where they have no cohesion."""
SLENDER = 5.0
"""Length over thickness above which beam theory predicts the deflection."""
BENT = 0.7071
"""Deflection of the end of a slender body, in thicknesses, above which the affine gradient bends it too far: the
border `bent_beam` of the atlas of failures."""


@dataclass(frozen=True)
class Choice:
    """values: keys of the solver with the chosen values; why: the reason in a few words."""

    values: dict[str, Any]
    why: str

    @property
    def dotted(self) -> list[tuple[str, Any]]:
        """Dotted keys and values."""
        return [(f"solver.{key}", value) for key, value in self.values.items()]

    def __str__(self) -> str:
        return ", ".join(f"{key} = {value!r}".replace("'", '"') for key, value in self.dotted) + (
            f": {self.why}")


@dataclass(frozen=True)
class Scheme(Choice):
    """Columns in place of volumes."""

    @property
    def dotted(self) -> list[tuple[str, Any]]:
        return [("solver.depth.scheme", "columns")]


@dataclass(frozen=True)
class Damping(Choice):
    """Damping of steps that are solved for."""

    @property
    def dotted(self) -> list[tuple[str, Any]]:
        return [("solver.implicit.damping", self.values["implicit"].damping)]


CALM = 0.3
"""Damping with which water under a sudden load follows the exact solution (tests/verification/test_solved_water.py)."""
GRAINS_AT_RANDOM = Choice({"sampling": "poisson"}, "rows of a lattice part where a column of grains stretches, and its"
                                                   " heap sinks by up to a quarter")
GRAINS_CALM = Choice({"transfer": "aflip", "flip_ratio": 0.99}, "the viscosity of apic stops a column of grains a tenth"
                                                                " to a fifth too early")
THIN_BEAM = Choice({"kernel": "cubic", "gradient": "shape"}, "a thin elastic body that bends by more than its thickness"
                                                             " hangs a sixth too low with the affine gradient")


def choices(scene: "Scene") -> list[Choice]:
    """`Choice`s for a scene whose tables have been validated individually."""
    if scene.solver.in_plan and not scene.saw_test:
        return _columns(scene)
    if scene.solver.method == "implicit":
        return _calm_water(scene)
    if scene.solver.method != "mpm" or scene.saw_test:
        return []
    if any(body.material not in scene.materials for body in scene.bodies):  # which is refused
        return []
    found = [GRAINS_AT_RANDOM, GRAINS_CALM] if _columns_of_grains(scene) else [THIN_BEAM] if _bends_far(scene) else []
    given = scene.solver.model_fields_set
    return [choice for choice in found if not given & choice.values.keys()]


def _columns(scene):
    """Columns where the scene needs them, and names no scheme."""
    found = for_columns(scene, last=not scene.switch)
    return _chosen(scene.solver, f"{found[0][0]} {found[0][2]}") if found else []


def _calm_water(scene):
    """Damping of water in steps with inertia, whose waves they cannot follow."""
    solved = scene.solver.implicit
    if not (scene.get("water") and solved and solved.time == "newmark") or "damping" in solved.model_fields_set:
        return []
    return [Damping({"implicit": solved.model_copy(update={"damping": CALM})},
                    "without damping waves in the water swing on: 13 % of the pressure after ten steps")]


def taking_over(solver):
    """`Choice`s for a solver that takes over from another method."""
    return _chosen(solver, "in columns, snow that is handed over keeps where it came from") if solver.in_plan else []


def _chosen(solver, why):
    if "scheme" in solver.depth.model_fields_set:
        return []
    return [Scheme({"depth": solver.depth.model_copy(update={"scheme": "columns"})}, why)]


def _columns_of_grains(scene):
    """Whether all bodies are columns of dry grains that stand free on level ground."""
    laws = [scene.materials[body.material] for body in scene.bodies]
    level = scene.terrain is None or (scene.terrain.kind == "plane" and scene.terrain.angle == 0.0)
    return (level and not scene.obstacles and not any(component.solid for component in components.used(scene)) and all(
        law.kind in GRAINS and law.get("cohesion", 0.0) == 0.0 for law in laws)
        and all(_has_room(scene, body.shape) for body in scene.bodies))


def _has_room(scene, shape):
    """Whether a box or an upright cylinder has room to spread by its own height to at least one side."""
    if shape.kind == "box":
        lower, upper = shape.min, shape.max
    elif shape.kind == "cylinder" and not any(shape.axis[:2]):
        lower = [centre - shape.radius for centre in shape.base[:2]] + [shape.base[2]]
        upper = [centre + shape.radius for centre in shape.base[:2]] + [shape.base[2] + shape.height]
    else:
        return False
    if scene.domain is None or scene.domain.min is None:
        return True
    height = upper[-1] - lower[-1]
    return any(scene.domain.max[a] - upper[a] > height or lower[a] - scene.domain.min[a] > height
               for a in range(scene.dimension - 1))


def _bends_far(scene):
    """Whether all bodies are elastic, and one of them, clamped at one end, deflects by more than BENT thicknesses."""
    if scene.terrain is not None or scene.domain is None or scene.domain.min is None:
        return False
    laws = [scene.materials[body.material] for body in scene.bodies]
    return all(law.kind == "elastic" for law in laws) and any(
        _hangs(scene, body.shape, law) > BENT for body, law in zip(scene.bodies, laws, strict=True))


def _hangs(scene, shape, law):
    """w / t = 3 rho g L^4 / 2 E' t^3 of a box that a side holds at one end, E' = E / (1 - nu^2); 0 of other bodies."""
    if shape.kind != "box":
        return 0.0
    length, thickness = shape.max[0] - shape.min[0], shape.max[-1] - shape.min[-1]
    sides, dx = scene.domain.sides(scene.dimension), scene.solver.dx
    held = [sides["x_min"] == "stick" and shape.min[0] < scene.domain.min[0] + dx,
            sides["x_max"] == "stick" and shape.max[0] > scene.domain.max[0] - dx]
    lies = shape.min[-1] < scene.domain.min[-1] + dx
    if sum(held) != 1 or lies or length < SLENDER * thickness:
        return 0.0
    modulus = law.youngs_modulus / (1.0 - law.poisson_ratio**2)
    return 1.5 * law.density * abs(scene.gravity_vector[-1]) * length**4 / (modulus * thickness**3)

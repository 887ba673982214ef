"""The particles of a cell change their volume, or deform, as one: the keys, and what they do not go with."""

from typing import Annotated, Literal

from pydantic import Field

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.spec import Spec


class OfSolver(Spec):
    """Keys of a scene's solver table."""

    f_bar: Annotated[bool, Field(strict=True)] | Literal["whole"] = False
    """mpm: the particles of a cell change their volume as one, against volumetric locking: nu above 0.45, plastic flow
    that keeps the volume; of steps that are solved for: implicit.f_bar. "whole": they deform as one, so that a crack
    of cohesive_crack opens in one row of cells"""


class OfImplicit(Spec):
    """Keys of its table implicit."""

    f_bar: Annotated[bool, Field(strict=True)] = False
    """the particles of a cell change their volume as one, against volumetric locking: nu above 0.45, plastic flow that
    keeps the volume"""


EXPLICIT, SOLVED = "solver.f_bar", "solver.implicit.f_bar"


def asked(scene):
    """(key, value) of both."""
    solver = scene.solver
    if solver.f_bar:
        yield EXPLICIT, solver.f_bar
    if solver.implicit and solver.implicit.f_bar:
        yield SOLVED, True


def refuse_elsewhere(scene):
    """Raise InputError for the key of other steps, and for a pressure around snow whose steps are solved for."""
    solver = scene.solver
    if solver.f_bar and solver.method == "implicit":
        raise InputError.at(EXPLICIT, solver.f_bar, f"applies to explicit steps only: set {SOLVED}", scene.source)
    if solver.implicit and solver.implicit.f_bar and any(force.kind == "pressure" for force in scene.forces):
        raise InputError.at(SOLVED, True, 'does not go with forces of kind "pressure"', scene.source)


COMPONENTS.add(Component(
    "f_bar", __package__, "one change of volume a cell", asked, order=30, rests=True,
    keys={"solver": OfSolver, "solver.implicit": OfImplicit},
    owns=("the deformation of particles",), beside=("water", "solver.kernel"), refuse=refuse_elsewhere,
    cautions=f"{__package__}.cautions"))

"""Scenes on which the suite of methods runs, made to what a method is capable of.

A method that is registered without an example fails the suite: add one here, and it has all the checks.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from snowmpm.methods import METHODS
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.schema import Scene

DX, SIDE, G = 0.1, 0.4, 9.81
DENSITY = 200.0
SNOW = {"kind": "anticrack_cam_clay", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
        "critical_slope": 1.0, "cohesion": 0.3, "hardening": 0.5, "p0": 2e4, "softening": 0.5}


@dataclass(frozen=True)
class Example:
    """What a method needs of a scene beside its name.

    grounded: whether its snow must lie on terrain; it then stays there, and moves level only. in_plan: whether its
    particles fill cells of a plan, whatever the depth. rest: keys of a scene with gravity whose snow stays where it
    is; by default a settled column, or without an initial stress no gravity. at_rest: speed [sqrt(g D)] below which
    that is rest. strength: times that of the snow, of a method that does not solve for snow which breaks as it hits a
    wall (docs/implicit.md). solver: keys of its solver; of the depth-averaged method those of the scheme whose
    particles move (finite volumes: tests/depth/test_volumes.py).
    """

    grounded: bool = False
    in_plan: bool = False
    rest: Mapping = field(default_factory=dict)
    at_rest: float = 0.01
    strength: float = 1.0
    solver: Mapping = field(default_factory=dict)


EXAMPLES = {"mpm": Example(), "sph": Example(), "implicit": Example(strength=1e3),
            "depth": Example(grounded=True, in_plan=True, solver={"depth": {"scheme": "columns"}})}


def without_example():
    """Names of the registry of methods that have no example."""
    return set(METHODS) - set(EXAMPLES)


def snow(method):
    """Snow for an impact that the method can solve for (`Example.strength`)."""
    return {**SNOW, "p0": EXAMPLES[method].strength * SNOW["p0"]}


def able(method):
    """`Capabilities` of a method."""
    return METHODS[method].capabilities


def can(method, capability):
    """Whether a method has a capability."""
    return METHODS[method].can(capability)


def least_dimension(method):
    """In which the suite runs where nothing else is said."""
    return min(able(method).dimensions)


def point(dim, x, z, y=0.0):
    return [x, z] if dim == 2 else [x, y, z]


def box(dim, lower, upper):
    """Between two x and two z; 0.4 m along y."""
    return {"kind": "box", "min": point(dim, lower[0], lower[1], 0.0), "max": point(dim, upper[0], upper[1], SIDE)}


def layer(dim, start, end, top):
    """On the terrain, between two x; 0.4 m along y."""
    across = {} if dim == 2 else {"y": [0.0, SIDE]}
    return {"kind": "layer", "bottom": 0.0, "top": top, "region": {"x": [start, end], **across}}


def body(shape, name="one", **more):
    return {"name": name, "material": "snow", "shape": shape, **more}


def block(dim, velocity=(0.0, 0.0, 0.0), start=0.0, name="one", **more):
    """A cube of snow from x = start on; velocity: along x, z and y."""
    return body(box(dim, (start, 0.0), (start + SIDE, SIDE)), name, velocity=point(dim, *velocity), **more)


def ground(method, angle=0.0, friction=0.0):
    """Terrain that snow may leave and that holds it back, as far as the method is capable of that."""
    can = able(method)
    return {"kind": "plane", "angle": angle, "friction": friction if can.ground_friction else 0.0,
            "contact": "separate" if "separate" in can.contacts else "slip"}


def scene(method, dim=None, *, precision=None, solver=None, **changes):
    """`Scene` of a block of snow without gravity, on level ground if the method needs that."""
    dim = dim or least_dimension(method)
    precision = precision or able(method).precisions[-1]
    tables = {
        "name": "conformance", "dimension": dim, "end_time": 1.0, "gravity": 0.0, "seed": 1,
        "solver": {"method": method, "dx": DX, "precision": precision, **EXAMPLES[method].solver, **(solver or {})},
        "domain": {"min": point(dim, -2.0, -3.0, -2.0), "max": point(dim, 3.0, 2.0, 2.0)},
        "materials": {"snow": SNOW}, "bodies": [block(dim)]}
    if EXAMPLES[method].grounded:
        tables["terrain"] = ground(method)
    return Scene.model_validate({**tables, **changes})


def resting(method):
    """`Scene` whose snow stays where it is."""
    example, dim = EXAMPLES[method], least_dimension(method)
    if example.rest or not can(method, "settling"):
        return scene(method, **example.rest)
    sides = {f"{axis}_{end}": "slip" for axis in ("xz" if dim == 2 else "xyz") for end in ("min", "max")}
    walls = {"min": point(dim, 0.0, 0.0, 0.0), "max": point(dim, SIDE, 2 * SIDE, SIDE),
             "boundary": sides | {"z_max": "open"}}
    return scene(method, gravity=G, domain=walls, initial={"stress": "settle", "tolerance": 0.01})


def eventful(method, dim=None, **changes):
    """`Scene` with as much of everything as the method is capable of: snow slides down a slope against a wall; it is
    cut, loaded and blown at, and a second body is taken out."""
    able_to, dim = able(method), dim or least_dimension(method)
    tables = {"gravity": G}
    first, second = box(dim, (0.0, 0.0), (0.6, 0.3)), box(dim, (1.2, 0.0), (1.6, 0.3))
    if able_to.terrain:
        first, second = layer(dim, 0.0, 0.6, 0.3), layer(dim, 1.2, 1.6, 0.3)
        tables["terrain"] = ground(method, 20.0, 0.3)
    tables["bodies"] = [body(first, velocity=point(dim, 6.0, -2.2)),
                        body(second, "two", velocity=point(dim, 15.0, -5.5))]
    across = [0.0] * (dim - 2)
    events = [
        (can(method, "cuts"), {"kind": "cut", "body": "one", "start": 0.001, "path": [
            point(dim, 0.1, 0.05, -1.0), point(dim, 0.4, -0.05, 1.0)]}),
        (can(method, "loads"), {"kind": "load", "body": "one", "centre": point(dim, 0.2, 0.1, 0.2), "radius": 0.15,
                                "force": [100.0, *across, -200.0]}),
        (can(method, "loads"), {"kind": "load", "body": "one", "force": [50.0, *across, 20.0], "start": 0.002}),
        (can(method, "removal"), {"kind": "remove", "body": "two", "start": 0.008})]
    tables["events"] = [event for possible, event in events if possible]
    if able_to.obstacles:
        tables["obstacles"] = [{"name": "wall", "shape": {
            "kind": "box", "min": point(dim, 0.64, -0.6, -0.4), "max": point(dim, 0.94, 0.5, 0.8)}}]
    forcing = COMPONENTS.get("forcing_and_damping")
    if forcing and forcing.supports(method) and not able_to.solves:
        tables["gravity"] = {"times": [0.0, 0.02], "values": [G, 9.0], "tilts": [0.0, 5.0]}
        tables["forces"] = [
            {"kind": "acceleration", "value": ["sin(40*t) - 0.1*vx", *["0.3*vy"] * (dim - 2), "0.2"],
             "within": {"min": point(dim, 0.0, -1.0, -1.0), "max": point(dim, 0.5, 1.0, 1.0)}},
            {"kind": "pressure", "value": "2000*step(0, 0.02, t)*(1 + 0.1*x)"},
            {"kind": "pressure", "acts_on": "pores", "value": "-500*z"}]
        tables["damping"] = {"coefficient": 3.0, "start": 0.004, "rest_speed": 1e-3}
    tables["materials"] = {"snow": snow(method)}
    return scene(method, dim, **{**tables, **changes})

"""Refusal of scenes with water in the pores beside what does not know it."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.schemes import TRANSFERS


def refuse_beside_water(scene):
    """Raise InputError for what does not go with water in the pores."""
    scheme = scene.water.scheme
    if METHODS[scene.solver.method].capabilities.solves:
        _refuse_beside_solved_water(scene)
    seeps = scheme in ("u_p", "v_w", "seepage")
    if seeps and scene.solver.precision != "f64":
        raise InputError.at("solver.precision", scene.solver.precision, 'must be "f64" beside water, whose'
                            " compression is smaller than the round-off of single precision", scene.source)
    if scene.switch:
        raise InputError.at("switch.0.to", scene.switch[0].to, "does not go with water, which no hand-over keeps",
                            scene.source)
    if seeps and scene.initial.stress == "geostatic":
        raise InputError.at("initial.stress", scene.initial.stress, 'does not go with water: "settle" finds the'
                            " effective stress", scene.source)
    if seeps and scene.initial.relaxation == "static":
        raise InputError.at("initial.relaxation", "static", 'must be "damped" beside water, whose weight and pressure'
                            " the balance does not know", scene.source)
    if scene.initial.from_run is not None:
        raise InputError.at("initial.from", scene.initial.from_run, "does not go with water, which is not taken over",
                            scene.source)
    if scene.saw_test:
        raise InputError.at("saw_test.slope_angle", scene.saw_test.slope_angle, "does not go with water", scene.source)
    if scheme == "v_w":
        _refuse_beside_two_velocities(scene)
    if scheme == "seepage":
        _refuse_beside_seepage(scene)
    if scheme == "two_phase" and scene.obstacles:
        raise InputError.at("water.scheme", "two_phase", 'does not go with obstacles: take "one_phase"', scene.source)


def _refuse_beside_solved_water(scene):
    """Raise InputError for surfaces that change how they hold the snow, beside water among the unknowns of a step."""
    terrain, sides = scene.terrain, scene.domain.sides(scene.dimension) if scene.domain else {}
    found = [(f"domain.boundary.{name}", side) for name, side in sides.items() if side in ("separate", "periodic")]
    found += [(f"obstacles.{i}.name", obstacle.name) for i, obstacle in enumerate(scene.obstacles)]
    if terrain and terrain.contact == "separate":
        found.append(("terrain.contact", terrain.contact))
    elif terrain and terrain.contact == "slip" and terrain.friction != 0.0:
        found.append(("terrain.friction", "a law" if not isinstance(terrain.friction, int | float)
                      else terrain.friction))
    if found:
        raise InputError.at(*found[0], f'does not go with water in solver.method = "{scene.solver.method}"',
                            scene.source)


def _refuse_beside_two_velocities(scene):
    """Raise InputError for what does not go with water that has a velocity of its own."""
    solver, terrain = scene.solver, scene.terrain
    if not TRANSFERS[solver.transfer].flip:
        raise InputError.at("solver.transfer", solver.transfer, 'must be "aflip" or "flip" beside water.scheme = "v_w",'
                            " which needs the velocity before the forces", scene.source)
    if scene.initial.stress not in ("none", "settle"):
        raise InputError.at("initial.stress", scene.initial.stress, 'must be "none" or "settle" beside'
                            ' water.scheme = "v_w"', scene.source)
    for i, event in enumerate(scene.events):
        if event.kind == "melt":
            raise InputError.at(f"events.{i}.kind", event.kind, 'does not go with water.scheme = "v_w": take "rain"'
                                f" with rate = {event.rate:.3g}", scene.source)
        if event.kind in ("drainage", "load"):
            raise InputError.at(f"events.{i}.kind", event.kind, 'does not go with water.scheme = "v_w": take "u_p"',
                                scene.source)
    # Laws take their stress from all particles of a column; the grains' own is known where they touch a surface only
    rubbing = [("terrain", terrain)] if terrain else []
    rubbing += [(f"obstacles.{i}", obstacle) for i, obstacle in enumerate(scene.obstacles)]
    for key, surface in rubbing:
        if surface.contact not in ("stick", "symmetric") and not isinstance(surface.friction, int | float):
            raise InputError.at(f"{key}.friction", "a law", 'must be a number beside water.scheme = "v_w"',
                                scene.source)


def _refuse_beside_seepage(scene):
    """Raise InputError for what does not go with water that seeps through grains at rest."""
    beside = 'does not go with water.scheme = "seepage", whose grains are at rest'
    if scene.initial.stress != "none":
        raise InputError.at("initial.stress", scene.initial.stress, beside, scene.source)
    for i, event in enumerate(scene.events):
        if event.kind != "rain":
            raise InputError.at(f"events.{i}.kind", event.kind, f"{beside}: only rain does", scene.source)
    for i, body in enumerate(scene.bodies):
        if np.any(body.velocity):
            raise InputError.at(f"bodies.{i}.velocity", list(body.velocity), beside, scene.source)
    for name, side in (scene.domain.sides(scene.dimension) if scene.domain else {}).items():
        if side not in ("open", "slip", "symmetric"):
            raise InputError.at(f"domain.boundary.{name}", side, 'must be "slip", "symmetric" or "open" beside'
                                ' water.scheme = "seepage"', scene.source)
    found = {"terrain.kind": scene.terrain and scene.terrain.kind,
             "obstacles.0.name": scene.obstacles and scene.obstacles[0].name}
    for key, value in found.items():
        if value:
            raise InputError.at(key, value, 'does not go with water.scheme = "seepage": sides of the domain hold it,'
                                " and weight moves it", scene.source)

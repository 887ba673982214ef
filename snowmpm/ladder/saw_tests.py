"""Rungs for saw tests: theories, the weak layer as an interface, the weak layer in cells, in profile and in 3-D."""

import numpy as np

from snowmpm.ladder.rung import IN_3D, Rung, in_cells, nearest_cells, spacing
from snowmpm.saw_test import theory, weac
from snowmpm.saw_test.prediction import column_of, predictions

ENERGY, STRENGTH, BEAM = "energy on a rigid layer", "shear strength", "WEAC"
INTERFACE, RESOLVED, FLAT = "interface", "resolved", "plane strain "
CELLS = {INTERFACE: (2, 4, 8, 16), RESOLVED: (5, 10, 20, 40)}
"""Cells over the slab."""
POINTS = 8
"""Points a cell and direction of an interface."""
BLIND = {
    ENERGY: "the elasticity and the strength of the weak layer, its way before the crack runs (Heierli et al. 2008)",
    STRENGTH: "collapse and mixed modes: the layer fails in shear (Gaume et al. 2017)",
    BEAM: "strength and damage: an elastic layer, a crack by energy alone (Rosendahl & Weissgraeber 2020)",
    INTERFACE: "waves and stress within the weak layer; the slab in few cells",
    RESOLVED: "a weak layer thinner than two cells",
    FLAT + INTERFACE: "the width of the column, waves and stress within the weak layer; the slab in few cells",
    FLAT + RESOLVED: "the width of the column; a weak layer thinner than two cells",
    IN_3D + INTERFACE: "waves and stress within the weak layer; the slab in few cells",
    IN_3D + RESOLVED: "a weak layer thinner than two cells",
}


def rungs(facts, ask):
    """`Rung`s of a saw test, from theories to the finest grid. facts: `SceneFacts`."""
    scene = facts.scene
    yield Rung(ENERGY, BLIND[ENERGY], answers=lambda: _by_energy(scene))
    yield Rung(STRENGTH, BLIND[STRENGTH], answers=lambda: _by_strength(scene))
    yield Rung(BEAM, BLIND[BEAM], answers=lambda: _by_weac(scene))
    slab = sum(layer.thickness for layer in scene.saw_test.slab)
    flat = FLAT if scene.dimension == 3 else ""
    for way in (INTERFACE, RESOLVED):
        for cells in CELLS[way]:
            yield Rung(flat + in_cells(way, cells), BLIND[flat + way], {
                **_weak_layer(scene, way, slab / cells), **_flat(scene), "solver.dx": spacing(slab, cells)})
    if scene.dimension == 3:
        for way in (INTERFACE, RESOLVED):
            for cells in CELLS[way]:
                yield Rung(IN_3D + in_cells(way, cells), BLIND[IN_3D + way],
                           {**_weak_layer(scene, way, slab / cells), "solver.dx": spacing(slab, cells)})


def own_name(facts, group):
    """Name of the rung that a saw test stands on, or is nearest to."""
    scene = facts.scene
    slab = sum(layer.thickness for layer in scene.saw_test.slab)
    way = INTERFACE if scene.saw_test.weak_layer.get("interface") else RESOLVED
    return (IN_3D if scene.dimension == 3 else "") + in_cells(way, nearest_cells(slab, scene.solver.dx, CELLS[way]))


def _weak_layer(scene, way, dx):
    """Changes that draw the weak layer as an interface, or by particles: two cells of it at least, else its true
    thickness."""
    layer = scene.saw_test.weak_layer
    own = {"material": layer.material, "thickness": layer.thickness}
    if way == RESOLVED:
        return {"saw_test.weak_layer": {**own, "cells": max(2, round(layer.thickness / dx))}}
    return {"saw_test.weak_layer": {**own, "interface": layer.get("interface") or POINTS},
            "solver.transfer": "aflip", "solver.flip_ratio": 0.99}


def _flat(scene):
    return {"dimension": 2, "saw_test.width": None} if scene.dimension == 3 else {}


def _by_energy(scene):
    found = predictions(scene)
    values = {"critical-length": found["critical_length_energy"], "crack-speed": _speed(scene, found)}
    return {name: value for name, value in values.items() if value}


def _by_strength(scene):
    length = predictions(scene)["critical_length_strength"]
    return {"critical-length": length} if length else {}


def _speed(scene, found):
    """Speed of a crack by theory [m/s]: the collapse wave, as long as the crushed layer would hold the slab; beyond,
    the plate wave of the slab."""
    slab, law, thickness = column_of(scene)
    strain, pressure, _, _ = theory.collapse_curve(law)
    collapse = theory.maxwell_load(strain, pressure)[1] * (law.collapse_thickness or thickness)
    if found["shear_stress"] > np.tan(np.radians(FRICTION)) * found["normal_stress"]:
        return found["plate_wave_speed"]
    return theory.collapse_speed(slab, collapse, scene.gravity) if collapse > 0.0 else None


FRICTION = 30.0
"""Friction angle of a crushed weak layer, about [degrees]."""


def _by_weac(scene):
    energy = predictions(scene)["fracture_energy"]
    length = weac.critical_length(scene, energy) if energy else None
    return {"critical-length": length} if length else {}

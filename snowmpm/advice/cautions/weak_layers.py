"""Rules: weak layers through which no crack runs on this grid, or another one than the scene was made for."""

from snowmpm.advice.cautions.caution import CURES, Caution, rule
from snowmpm.advice.weak_layers import LEAST_CELLS, SLACK, weak_layers
from snowmpm.errors import InputError
from snowmpm.measured.borders import shipped
from snowmpm.scenes import load_scene

SMOOTH_CELLS = 4.0
"""Cells through a broken weak layer on which a slab slides as its law says, to 5 %
(tests/components/interface_layer/test_interface_friction.py)."""
OFF = 1.25
"""Fracture energy over that of the scene's own grid that matters, as the limit of the entry softening_on_grid."""


@rule("mpm")
def cells_through_weak_layer(facts):
    """Fewer cells through a weak layer than a crack needs."""
    for layer in weak_layers(facts.scene):
        cells = facts.thickness(layer.body)
        if cells < LEAST_CELLS * (1.0 - SLACK):
            more = "".join(cure(facts, layer) for cure in CURES.get("cells_through_weak_layer", ()))
            yield Caution("", f"bodies.{layer.body} ({layer.name})",
                          f"{cells:.3g} cells through a weak layer are fewer than {LEAST_CELLS:g}: cracks may not run"
                          " in it, and nothing is released",
                          f"solver.dx = {cells * facts.dx / LEAST_CELLS:.3g} or less{more}")


@rule("mpm")
def rough_weak_layer(facts):
    """So few cells that a broken weak layer rubs as the rows of snow beside it."""
    if facts.scene.saw_test:
        return
    for layer in weak_layers(facts.scene):
        cells = facts.thickness(layer.body)
        if LEAST_CELLS * (1.0 - SLACK) <= cells < SMOOTH_CELLS * (1.0 - SLACK):
            yield Caution("", f"bodies.{layer.body} ({layer.name})", f"{cells:.3g} cells through a weak layer: once"
                          " broken it rubs as the snow beside it; on two cells a slab slid as on 0.57 for 0.40",
                          f"solver.dx = {cells * facts.dx / SMOOTH_CELLS:.3g} where the slab is to slide as its law"
                          " says")


@rule("mpm")
def another_grid(facts):
    """A softening that the scene's file gives with its dx, on another dx."""
    scene = facts.scene
    layers = [layer for layer in weak_layers(scene) if layer.tuned]
    if not layers or "solver.dx" not in scene.overrides:
        return
    try:
        own = load_scene(scene.source).solver.dx
    except InputError:  # it came from no file
        return
    ratio = facts.dx / own
    if ratio <= OFF and not shipped()["softening_on_grid", "as given"].failing(ratio):
        return
    for layer in layers:
        if any(key.startswith(f"materials.{layer.material}") for key in scene.overrides):
            continue  # chosen anew for this grid
        effect = "cracks need longer cuts and may not run" if ratio > 1.0 else "the layer may fail by itself"
        yield Caution("softening_on_grid", f"solver.dx ({layer.name})", f"{facts.dx:g} is {ratio:.3g} times the"
                      f" {own:g} of the scene's file, on which the softening of {layer.material} was chosen: the energy"
                      f" to break it goes with dx, so that {effect}",
                      f"solver.dx = {own:g}, or materials.{layer.material}.softening chosen anew")

"""Rules: weak layers as interfaces under too few cells."""

from dataclasses import replace

from snowmpm.advice.cautions.caution import accepted, beyond, cure, rounded_down, rule, worded


@rule("mpm")
def coarse_interface(facts):
    """A slab of few cells above an interface whose layer breaks."""
    scene = facts.scene
    setting = "aflip" if scene.solver.transfer == "aflip" else "flip"
    for body, spec in enumerate(scene.bodies):
        if spec.interface and scene.materials[spec.material].collapses:
            cells = _slab(facts) / facts.dx
            if border := beyond("coarse_interface", setting, cells):
                found = worded(border, "solver.dx", cells, f"above bodies.{body} ({spec.name}): cells over the slab")
                yield replace(found, cure=f"solver.dx = {rounded_down(cells * facts.dx / border.value):g} or less")
                return


def _slab(facts):
    """Thickness [m] of the snow above the interfaces."""
    if facts.scene.saw_test is not None:
        return sum(layer.thickness for layer in facts.scene.saw_test.slab)
    return facts.dx * max(facts.thickness(body) for body, spec in enumerate(facts.scene.bodies) if not spec.interface)


@cure("cells_through_weak_layer")
def or_interface(facts, layer):
    """The key that makes an interface of a layer, where the scene takes it; else that there is such a thing."""
    saw = facts.scene.saw_test
    key, points = f"bodies.{layer.body}.interface", 4 if facts.scene.dimension == 2 else 2
    if saw:
        key = "saw_test.weak_layer.interface"
    said = f", or {key} = {points}" if accepted(facts, {key: points}) else "; or the layer as an interface"
    return f"{said} (`snowmpm docs interface`)"

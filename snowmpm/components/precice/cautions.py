"""Rule: what is not known of a structure that another program computes."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.components.precice.from_scene import externals, windows
from snowmpm.components.structures.from_scene import line_mass_held


@rule("mpm", "sph")
def external_structure(facts):
    """What is not known of a structure that another program computes: its cost, and its mass where coupling is
    explicit."""
    own, scene = windows(facts.scene), facts.scene
    for i, spec in externals(scene):
        key = f"structures.{i}.precice.file"
        if i == externals(scene)[0][0]:
            size = "each step is a time window" if own.size is None else (
                f"{np.ceil(scene.end_time / own.size - 1e-6):.0f} time windows of {own.size:g} s")
            again = ", each computed several times, by the snow as well" if own.implicit else ""
            yield Caution("", key, f"the forecast leaves out the other program: {size}{again}",
                          "time a few windows of it by itself")
        if not own.implicit:
            held = line_mass_held(scene, spec.width, max(law.density for law in facts.model.laws))
            yield Caution("light_structure", key, f"{own.scheme} coupling is unstable where the structure has less mass"
                          f" than the snow in the cells around it, {held:.3g} kg/m along it",
                          "an implicit scheme, or a structure with more mass")

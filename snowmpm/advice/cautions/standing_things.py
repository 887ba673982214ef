"""Rules: structures that bend in the snow."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, beyond, rule, worded
from snowmpm.scenes.external import External
from snowmpm.scenes.frameworks import Framework
from snowmpm.setup.external import externals, windows
from snowmpm.setup.standing import heaviest_held, line_mass_held


@rule("mpm", "sph")
def few_segments(facts):
    """A mast of fewer pieces than its deflection needs; elements of a framework bend by themselves."""
    for i, spec in enumerate(facts.scene.structures):
        if isinstance(spec, Framework | External):
            continue
        if border := beyond("few_segments", "load at its end", float(spec.segments)):
            yield worded(border, f"structures.{i}.segments", float(spec.segments))


@rule("mpm", "sph")
def few_elements(facts):
    """A member of so few elements that the load along it hardly bends its ends."""
    for i, (spec, one) in enumerate(zip(facts.scene.structures, facts.model.rods, strict=True)):
        if isinstance(spec, Framework):
            for k, member in enumerate(one.mesh.members):
                if border := beyond("few_elements", "both ends fixed", float(member.segments)):
                    yield worded(border, f"structures.{i}.members.{k}.segments", float(member.segments))
                    break


@rule("mpm", "sph")
def light_structure(facts):
    """A structure with weak coupling that snow cannot leave, by the mass of the snow that contact holds."""
    for i, (spec, rod) in enumerate(zip(facts.scene.structures, facts.model.rods, strict=True)):
        if isinstance(spec, External):
            continue
        share, _ = heaviest_held(facts.scene, spec, rod, max(law.density for law in facts.model.laws))
        setting = "weak, separate" if spec.contact == "separate" else "weak, stick"
        entry = "light_framework" if isinstance(spec, Framework) else "light_structure"
        if spec.coupling == "weak" and (border := beyond(entry, setting, share)):
            yield worded(border, f"structures.{i}.coupling", share)


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


@rule("mpm", "sph")
def short_segments(facts):
    """Pieces shorter than a cell, which the grid does not tell apart."""
    for i, (spec, rod) in enumerate(zip(facts.scene.structures, facts.model.rods, strict=True)):
        for key, n, enough, length in _pieces(spec, rod):
            if length < facts.dx and n > enough:
                most = max(enough, int(length * n / facts.dx))
                says = (f"{n} pieces of {length / facts.dx:.2g} cells: the snow does not tell them apart, and each"
                        " costs as much as an obstacle")
                yield Caution("", f"structures.{i}.{key}", says, f"{most} segments")


def _pieces(spec, rod):
    """Key of the number of segments, the number, how many are enough to bend, and their length [m]: of a mast, or of
    each member of a framework."""
    if not isinstance(spec, Framework):
        return [("segments", rod.n, 8, rod.lengths.min())]
    return [(f"members.{k}.segments", member.segments, 4, rod.lengths[rod.mesh.elements(k)[0]])
            for k, member in enumerate(rod.mesh.members)]

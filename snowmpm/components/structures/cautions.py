"""Rules: structures that bend in the snow."""

from snowmpm.advice.cautions.caution import Caution, beyond, rule, worded
from snowmpm.components.structures.framework_tables import Framework
from snowmpm.components.structures.from_scene import heaviest_held
from snowmpm.components.structures.tables import Structure


@rule("mpm", "sph")
def few_segments(facts):
    """A mast of fewer pieces than its deflection needs; elements of a framework bend by themselves."""
    for i, spec in enumerate(facts.scene.structures):
        if not isinstance(spec, Structure):
            continue
        if border := beyond("few_segments", "load at its end", float(spec.segments)):
            yield worded(border, f"structures.{i}.segments", float(spec.segments))


@rule("mpm", "sph")
def few_elements(facts):
    """A member of so few elements that the load along it hardly bends its ends."""
    for i, (spec, one) in enumerate(_pairs(facts)):
        if isinstance(spec, Framework):
            for k, member in enumerate(one.mesh.members):
                if border := beyond("few_elements", "both ends fixed", float(member.segments)):
                    yield worded(border, f"structures.{i}.members.{k}.segments", float(member.segments))
                    break


@rule("mpm", "sph")
def light_structure(facts):
    """A structure with weak coupling that snow cannot leave, by the mass of the snow that contact holds."""
    for i, (spec, rod) in enumerate(_pairs(facts)):
        if not spec.OWN:
            continue
        share, _ = heaviest_held(facts.scene, spec, rod, max(law.density for law in facts.model.laws))
        setting = "weak, separate" if spec.contact == "separate" else "weak, stick"
        entry = "light_framework" if isinstance(spec, Framework) else "light_structure"
        if spec.coupling == "weak" and (border := beyond(entry, setting, share)):
            yield worded(border, f"structures.{i}.coupling", share)


@rule("mpm", "sph")
def short_segments(facts):
    """Pieces shorter than a cell, which the grid does not tell apart."""
    for i, (spec, rod) in enumerate(_pairs(facts)):
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


def _pairs(facts):
    """Table of each structure, and what was made of it."""
    return zip(facts.scene.structures, facts.model.made.get("structures", ()), strict=True)

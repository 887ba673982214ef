"""All entries of the atlas, by group and by name."""

import importlib

from snowmpm import components
from snowmpm.study.atlas import (
    bending,
    columns_in_plan,
    contacts,
    granular,
    layers,
    round_off,
    softening,
    sph_lattices,
    stretching,
    time_steps,
    transfers,
    volumes_in_plan,
)

GROUPS = {
    "time steps": time_steps.ENTRIES,
    "transfers and splines": transfers.ENTRIES,
    "large deformation": (*stretching.ENTRIES, *bending.ENTRIES),
    "materials and layers": (*layers.ENTRIES, *granular.ENTRIES, *softening.ENTRIES),
    "contact": contacts.ENTRIES,
    "bodies and structures": (),
    "round-off and laws": round_off.ENTRIES,
    "sums of SPH": sph_lattices.ENTRIES,
    "depth-averaged flow": (*columns_in_plan.ENTRIES, *volumes_in_plan.ENTRIES),
    "water in the pores": (),
}
for component in components.declared():
    if component.atlas:
        for group, entries in importlib.import_module(component.atlas).ATLAS.items():
            GROUPS[group] = (*GROUPS.get(group, ()), *entries)
GROUPS = {group: entries for group, entries in GROUPS.items() if entries}
ENTRIES = {entry.name: entry for entries in GROUPS.values() for entry in entries}

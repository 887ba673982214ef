"""All entries of the atlas, by group and by name."""

from snowmpm.study.atlas import (
    averaging,
    bending,
    columns_in_plan,
    contacts,
    frameworks,
    granular,
    interfaces,
    layers,
    round_off,
    seeping,
    sleeping,
    soaked,
    softening,
    sph_lattices,
    standing,
    stretching,
    ties,
    time_steps,
    transfers,
)

GROUPS = {
    "time steps": time_steps.ENTRIES,
    "transfers and splines": transfers.ENTRIES,
    "large deformation": (*stretching.ENTRIES, *bending.ENTRIES),
    "materials and layers": (*layers.ENTRIES, *granular.ENTRIES, *softening.ENTRIES,
                             *averaging.ENTRIES, *interfaces.ENTRIES),
    "contact": (*contacts.ENTRIES, *ties.ENTRIES),
    "bodies and structures": (*standing.ENTRIES, *frameworks.ENTRIES),
    "snow at rest": sleeping.ENTRIES,
    "round-off and laws": round_off.ENTRIES,
    "sums of SPH": sph_lattices.ENTRIES,
    "depth-averaged flow": columns_in_plan.ENTRIES,
    "water in the pores": (*soaked.ENTRIES, *seeping.ENTRIES),
}
ENTRIES = {entry.name: entry for entries in GROUPS.values() for entry in entries}

"""The laws of a scene applied to a pack of particles (`materials.packs`)."""

import functools

from snowmpm.compiler import ti
from snowmpm.materials.law import REDO
from snowmpm.materials.packs import LANES, held_numbers, read_lane, update_lane, update_pack
from snowmpm.particles.response import response_functions


def most_held(laws, entries, width=LANES):
    """Numbers a lane that the laws of a scene hold in `pack["held"]`. entries: of a symmetric tensor."""
    return max(held_numbers(law.vector_update, entries) for law in laws) if width == LANES else 0


@functools.cache
def law_functions(layout, real, laws, width=LANES):
    """`apply_laws(pack, first, count, material, materials, law_of, dt)`.

    width: lanes of a pack; in packs of other widths than LANES the particles are taken one by one.
    laws: `LawFunctions` of a scene. pack: as `packs.update_pack` takes it, with `most_held` arrays "held"; written too,
    where a law stiffens, strain and wave2, where one has bonds, breaks.
    """
    n_laws, vector_update = len(laws), [law.vector_update for law in laws]
    # Laws that differ in straight-line updates alone share the other one, and it is compiled once
    updates = list(dict.fromkeys((law.update, law.names) for law in laws))
    example = [next(k for k, law in enumerate(laws) if (law.update, law.names) == update) for update in updates]
    update_of = [updates.index((law.update, law.names)) for law in laws]
    has_vector_update = [function is not None and width == LANES for function in vector_update]
    some_stiffen = any(law.stiffness is not None for law in laws)
    some_bonded = any(law.bonds is not None for law in laws)
    particle = response_functions(layout, real, laws)

    @ti.func
    def apply_laws(pack: ti.template(), first, count, material: ti.template(), materials: ti.template(),
                   law_of: ti.template(), dt):
        """A pack of one material at once as far as its law can, everything else particle by particle."""
        common, alike = ti.cast(material[first], ti.i32), 1
        for lane in range(count):
            pack["iterations"][lane] = REDO
            if material[first + lane] != common:
                alike = 0
        if alike == 1:
            for k in ti.static(range(n_laws)):
                if ti.static(has_vector_update[k]):  # noqa: SIM102 (one is compile time)
                    if law_of[common] == k:
                        update_pack(vector_update[k], particle.parameters_of(k, materials, common), dt, pack)
        left = 0
        for lane in range(width):
            left += ti.select(pack["iterations"][lane] == REDO, 1, 0)
        some_left = left > 0 or ti.static(some_stiffen or some_bonded)
        for lane in range(ti.select(some_left, count, 0)):
            own = ti.cast(material[first + lane], ti.i32)
            update = -1
            for k in ti.static(range(n_laws)):
                update = ti.select(law_of[own] == k, ti.static(update_of[k]), update)
            for j in ti.static(range(len(updates))):
                if update == j and pack["iterations"][lane] == REDO:
                    update_lane(updates[j][0], lane, particle.parameters_of(example[j], materials, own), dt, pack)
            for k in ti.static(range(n_laws if some_stiffen or some_bonded else 0)):
                if law_of[own] == k:
                    if ti.static(some_stiffen):
                        strain, wave2 = particle.extremes_of_law(k, materials, own, read_lane(pack["h"], lane),
                                                        read_lane(pack["tau"], lane), read_lane(pack["state"], lane))
                        pack["strain"][0][lane], pack["wave2"][0][lane] = strain, wave2
                    if ti.static(some_bonded):
                        pack["breaks"][0][lane] = particle.breaks(k, materials, own, read_lane(pack["state"], lane),
                                                                  pack["work"][lane])

    return apply_laws

"""Ways to compute an observed avalanche: every class of ground friction, and other methods with that of the scene."""

from snowmpm.errors import InputError
from snowmpm.events import store
from snowmpm.scenes import friction_cards, load_scene
from snowmpm.scenes.terrain import Plane

COULOMB_DEFAULT = Plane.model_fields["friction"].default
COULOMB = f"Coulomb {COULOMB_DEFAULT:g}, of a scene that names none"
MPM = {"solver.method": "mpm", "materials.snow": {"card": "li_cold_dense", "critical_slope": 0.8},
       "initial.stress": "geostatic"}
"""Three dimensions, with the snow of the library's avalanche_on_raster."""
COARSEST = 2.0
"""Largest cell of MPM, in thicknesses of the release."""


def ways(name):
    """{way: changes of the scene} of an event, the scene as it is first, under the name of its friction. InputError for
    one that is not depth-averaged."""
    scene = load_scene(store.PREFIX + name)
    if scene.solver.method != "depth":
        raise InputError.at("solver.method", scene.solver.method, 'must be "depth" to be computed in every way',
                            scene.source)
    friction = scene.terrain.friction
    law = "" if isinstance(friction, float) else friction.get("card") or f"{friction.law} of the scene"
    own = law or f"Coulomb {friction:g}"
    found = {own: {"solver.depth.scheme": scene.solver.depth.scheme}}
    found |= {card: {"terrain.friction": {"card": card}} for card in friction_cards() if card != own}
    if friction != COULOMB_DEFAULT:
        found[COULOMB] = {"terrain.friction": COULOMB_DEFAULT}
    found |= {f"{own}, by {scheme}": {"solver.depth.scheme": scheme} for scheme in ("volumes", "columns")
              if scheme != scene.solver.depth.scheme}
    tops = [top for body in scene.bodies if isinstance(top := body.shape.get("top"), float)]
    thinnest = min(tops, default=1.0)
    found[f"{own}, by mpm"] = {**MPM, "solver.dx": COARSEST * thinnest}
    for way, changes in store.event(name).ways.items():
        where = f"{store.PREFIX}{name}: ways.{way!r}"
        if way in found:
            raise InputError(f"{where}: is the name of a way of the program: take another")
        try:
            load_scene(store.PREFIX + name, changes)
        except InputError as error:
            raise InputError(f"{where}: {error}") from None
        found[way] = changes
    return found

"""Ways to compute an observed avalanche: every class of ground friction, and other methods with that of the scene."""

from snowmpm.errors import InputError
from snowmpm.events import store
from snowmpm.scenes import friction_cards, load_scene
from snowmpm.scenes.terrain import Plane

AS_IT_IS = "as the scene is"
COULOMB_DEFAULT = Plane.model_fields["friction"].default
COULOMB = f"Coulomb {COULOMB_DEFAULT:g}, of a scene that names none"
MPM = {"solver.method": "mpm", "materials.snow": {"card": "li_cold_dense", "critical_slope": 0.8},
       "initial.stress": "geostatic"}
"""Three dimensions, with the snow of the library's avalanche_on_raster."""
COARSEST = 2.0
"""Largest cell of MPM, in thicknesses of the release."""


def ways(name):
    """{way: changes of the scene} of an event: the scene as it is first. InputError for one that is not
    depth-averaged."""
    scene = load_scene(store.PREFIX + name)
    if scene.solver.method != "depth":
        raise InputError.at("solver.method", scene.solver.method, 'must be "depth" to be computed in every way',
                            scene.source)
    friction = scene.terrain.friction
    own = None if isinstance(friction, float) else friction.get("card")
    found = {AS_IT_IS: {"solver.depth.scheme": scene.solver.depth.scheme}}
    found |= {card: {"terrain.friction": {"card": card}} for card in friction_cards() if card != own}
    if friction != COULOMB_DEFAULT:
        found[COULOMB] = {"terrain.friction": COULOMB_DEFAULT}
    found |= store.event(name).ways
    found |= {f"as the scene is, by {scheme}": {"solver.depth.scheme": scheme} for scheme in ("volumes", "columns")
              if scheme != scene.solver.depth.scheme}
    tops = [top for body in scene.bodies if isinstance(top := body.shape.get("top"), float)]
    thinnest = min(tops, default=1.0)
    found["as the scene is, by mpm"] = {**MPM, "solver.dx": COARSEST * thinnest}
    return found

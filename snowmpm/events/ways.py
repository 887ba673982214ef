"""Ways to compute an observed avalanche: every class of ground friction, and other methods with that of the scene."""

from snowmpm.events import store
from snowmpm.scenes import friction_cards, load_scene

AS_IT_IS = "as the scene is"
COULOMB = "Coulomb 0.3, of a scene that names none"
MPM = {"solver.method": "mpm", "materials.snow": {"card": "li_cold_dense", "critical_slope": 0.8},
       "initial.stress": "geostatic"}
"""Three dimensions, with the snow of the library's avalanche_on_raster."""
COARSEST = 2.0
"""Largest cell of MPM, in thicknesses of the release."""


def ways(name):
    """{way: changes of the scene} of an event: the scene as it is first."""
    scene = load_scene(store.PREFIX + name)
    found = {AS_IT_IS: {"solver.depth.scheme": "volumes"}}
    found |= {card: {"terrain.friction": {"card": card}} for card in friction_cards()}
    found[COULOMB] = {"terrain.friction": 0.3}
    found |= store.event(name).ways
    found["as the scene is, by columns"] = {"solver.depth.scheme": "columns"}
    tops = [top for body in scene.bodies if isinstance(top := body.shape.get("top"), float)]
    thinnest = min(tops, default=1.0)
    found["as the scene is, by mpm"] = {**MPM, "solver.dx": COARSEST * thinnest}
    return found

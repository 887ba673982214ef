"""A slab on a plane of 30 degrees that starts with one method and goes on with another, in seconds."""

from snowmpm.scenes import Scene

ANGLE = 30.0
BODY = {"name": "slab", "material": "snow",
        "shape": {"kind": "layer", "top": 1.0, "region": {"x": [5.0, 17.0], "y": [6.0, 14.0]}}}
SOLVERS = {"mpm": {"method": "mpm", "dx": 0.5}, "sph": {"method": "sph", "dx": 0.5},
           "depth": {"method": "depth", "dx": 1.0}}


def scene(first="mpm", then="depth", when="t > 0.6", **changes):
    """The scene from the method `first` to `then`; changes: of its tables; `switch` in it: of the switch's."""
    solver = {name: value for name, value in SOLVERS[then].items() if name != "method"}
    tables = {
        "name": "slab", "dimension": 3, "end_time": 1.2, "output": {"interval": 0.2},
        "solver": SOLVERS[first],
        "domain": {"min": [0.0, 0.0, -30.0], "max": [40.0, 20.0, 10.0]},
        "terrain": {"kind": "plane", "angle": ANGLE, "friction": 0.3, "contact": "separate"},
        "materials": {"snow": {"card": "li_cold_dense", "critical_slope": 0.8}},
        "bodies": [BODY], "initial": {"stress": "geostatic"},
        **changes,
        "switch": [{"to": then, "when": when, "solver": solver, **changes.get("switch", {})}]}
    return Scene.model_validate(tables)

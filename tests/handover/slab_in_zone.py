"""The slab on a plane of `slab_in_two_methods`, as columns, and within a region in three dimensions."""

from snowmpm.scenes import Scene
from tests.handover.slab_in_two_methods import SOLVERS, scene

REGION = {"x": [18.0, 40.0], "y": [0.0, 20.0]}
WALL = {"name": "wall", "contact": "separate", "friction": 0.3, "shape": {
    "kind": "box", "min": [30.0, 4.0, -24.0], "max": [31.5, 16.0, -8.0]}}


def zoned(region=None, zone=None, **changes):
    """The scene; zone: of its table `zone`; changes: of the other tables."""
    tables = scene("depth", "mpm", **changes).model_dump(exclude_none=True, by_alias=True)
    del tables["switch"]
    return Scene.model_validate({**tables, "zone": {"region": region or REGION,
                                                    "solver": {"dx": SOLVERS["mpm"]["dx"]}, **(zone or {})}})


def level(speed, region, **changes):
    """A layer of 1 m between smooth walls on level ground without friction: at rest, or a block that slides."""
    x = [2.0, 14.0] if speed else [0.0, 20.0]
    along = "open" if speed else "slip"
    body = {"name": "slab", "material": "snow", "velocity": [speed, 0.0, 0.0],
            "shape": {"kind": "layer", "top": 1.0, "region": {"x": x, "y": [0.0, 6.0]}}}
    return zoned(region, bodies=[body], terrain={
        "kind": "plane", "angle": 0.0, "friction": 0.0, "contact": "separate"}, domain={
        "min": [0.0, 0.0, -2.0], "max": [40.0 if speed else 20.0, 6.0, 4.0],
        "boundary": {"x_min": along, "x_max": along, "y_min": "slip", "y_max": "slip"}}, **changes)

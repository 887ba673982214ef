"""What stands in the way of a flow, in plan: obstacles and dams, by name."""

import numpy as np

MANY = 20000
"""Triangles of an obstacle above which its footprint is the hull of its corners."""


def footprints(run):
    """{name: shapely polygon} of the obstacles of a `Run` in three dimensions where the scene draws them, in map
    coordinates [m]; without those that cover nothing."""
    import shapely  # slow to import

    found = {}
    for name, obstacle in run.obstacles.items() if run.dimension == 3 else ():
        corners = obstacle.vertices[:, :2] + run.origin[:2]
        if len(obstacle.facets) > MANY:
            footprint = shapely.MultiPoint(corners).convex_hull
        else:
            rings = corners[obstacle.facets]
            (ux, uy), (vx, vy) = ((rings[:, k] - rings[:, 0]).T for k in (1, 2))
            lying = ux * vy != uy * vx
            footprint = shapely.union_all(shapely.polygons(rings[lying]))
        if footprint.area > 0.0:
            found[name] = footprint
    return found


def dam_lines(run):
    """{name: corners (n, 2) of its crest in map coordinates [m]} of the dams of a `Run`."""
    dams = (run.scene.get("terrain") or {}).get("dams") or () if run.provenance.get("scene") else ()
    return {dam["name"]: np.array(dam["line"], float) for dam in dams}

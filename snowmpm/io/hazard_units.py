"""Units of the numbers of hazard mapping that a run file holds (`snowmpm.hazard` defines them)."""

UNITS = {
    "release_area": "m2", "release_volume": "m3", "top": "m", "runout": "m", "fall": "m", "travel_angle": "degrees",
    "runout_x": "m", "runout_y": "m", "runout_z": "m", "affected_area": "m2",
    "largest_depth": "m", "largest_speed": "m/s", "largest_pressure": "Pa", "deposit_area": "m2",
    "deposit_volume": "m3", "deposit_mean_depth": "m", "flow_depth": "m", "moving_share": "1",
}


def unit_of(name):
    """Unit of one of the numbers."""
    return "m2" if name.startswith("area_above") else "m" if name.startswith("reach_of") else UNITS[name]

"""Campaigns: many runs of one scene, on any number of machines, into one answer.

    import snowmpm
    found = snowmpm.campaign("avalanche_depth_averaged", {"mu": {"key": "terrain.friction.mu",
                             "distribution": "uniform", "low": 0.2, "high": 0.3}}, "campaigns/mu", runs=100)
    found.table, found.maps

The folder is not called `campaign`, since `snowmpm.campaign` is the function.
"""

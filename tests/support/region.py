"""A small region, and a roof whose release areas are known."""

import numpy as np

from snowmpm.region.release_terrain import Rule

TEXT = """name = "trial"
terrain = "massif.tif"
most_releases = 4
[scenarios.rare]
period = 100.0
thickness = {{ three_day_snow = 1.6 }}
[flow]
cell = 20.0
end_time = 60.0
[friction]
card = "voellmy_avaframe"
{more}
"""
ROOF = Rule(least=28.0, mean=28.0, scale=10_000.0, largest=400_000.0)
"""One area a face, however large."""


def roof(n=120, cell=5.0, angle=36.0):
    """Heights of two faces of one slope that fall to the west and to the east from a ridge in the middle."""
    x = cell * (np.arange(n) + 0.5 - n / 2)
    return np.broadcast_to(2000.0 - np.tan(np.radians(angle)) * np.abs(x), (n, n)).copy()

"""A layer of snow on a slope from a file, as scene text, and the good slope: what hostile input is put in place of."""

SCENE = """
name = "slope"
dimension = 3
end_time = {end_time}
[solver]
dx = {dx}
[materials.snow]
kind = "elastic"
density = 300.0
youngs_modulus = 1e5
poisson_ratio = 0.2
[[bodies]]
name = "release"
material = "snow"
shape = {shape}
"""
SQUARE = "{ x = [2, 8], y = [2, 8] }"
RING = [[2, 2], [8, 2], [8, 8], [2, 8], [2, 2]]
RASTER_HEADER = "ncols 12\nnrows 12\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n"


def slope_scene(file, kind="mesh", region=SQUARE, dx=1.0, end_time=0.02):
    """Text of the scene of a layer on the terrain in a file; region: its outline in plan, as TOML."""
    shape = f'{{ kind = "layer", top = 2.0, region = {region} }}'
    return SCENE.format(end_time=end_time, dx=dx, shape=shape) + f'[terrain]\nkind = "{kind}"\nfile = "{file}"\n'


def raster_text(rows):
    """An ESRI ASCII raster of 12 rows of 12 heights [m]."""
    return RASTER_HEADER + "\n".join(" ".join(f"{height:g}" for height in row) for row in rows) + "\n"

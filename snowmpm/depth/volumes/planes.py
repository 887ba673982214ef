"""The ground of each cell as a plane, and velocities in plan of snow that moves along it."""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Double, grouped_kernel
from snowmpm.compiler.parallel import strided, strides
from snowmpm.depth.volumes.arrays import TILE, Cells, Tiles


@ti.func
def limited(a, b):
    """Slope of a cell from the differences to either side: their mean, or twice the smaller where that is less, and 0
    where they differ in sign (van Leer 1977, doi:10.1016/0021-9991(77)90095-X)."""
    found = 0.0 * a
    if a * b > 0.0:
        least = 2.0 * ti.min(ti.abs(a), ti.abs(b))
        found = ti.max(-least, ti.min(least, 0.5 * (a + b)))
    return found


@ti.func
def slope_at(cells: ti.template(), c):
    """s of a cell."""
    return ti.Vector([cells.ground[c, 0], cells.ground[c, 1]])


@ti.func
def velocity_of(cells: ti.template(), c):
    """w of a cell [m/s]."""
    return ti.Vector([cells.state[c, 1], cells.state[c, 2]])


@ti.func
def carried(w, a, ca, b, cb):
    """A velocity w in plan, along the plane of slope a, turned into that of slope b: as long as before. ca, cb: the
    cosines of the planes."""
    return w + (a * ca + b * cb) * (cb * w.dot(a - b) / (1.0 + ca * cb * (1.0 + a.dot(b))))


@ti.func
def surface_speed(u, v, sx, sy):
    """Speed along the ground of slope (sx, sy) of a velocity (u, v) in plan."""
    return ti.sqrt(u * u + v * v + (u * sx + v * sy) ** 2)


@functools.cache
def shape_kernel(real, serial):
    """Kernel that takes the shape of the ground from its heights (n,) [m] in the middles of the cells."""

    @grouped_kernel(real)
    def shape(cells: Cells, heights: Array, tiles: Tiles, dx: Double):
        """Slope, curvature and cosine of the ground in live tiles, by central differences."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    if 1 < i < tiles.nx - 2 and 1 < j < tiles.ny - 2:
                        c, middle = i * tiles.ny + j, heights[i * tiles.ny + j]
                        right, left = heights[c + tiles.ny], heights[c - tiles.ny]
                        over, under = heights[c + 1], heights[c - 1]
                        s = ti.Vector([right - left, over - under]) / (2.0 * dx)
                        twist = (heights[c + tiles.ny + 1] - heights[c + tiles.ny - 1]
                                 - heights[c - tiles.ny + 1] + heights[c - tiles.ny - 1])
                        # over four cells: bends of single cells, and the noise of a survey, are not those of a flow
                        wide = (heights[c + 2 * tiles.ny] + heights[c - 2 * tiles.ny] - 2.0 * middle,
                                heights[c + 2] + heights[c - 2] - 2.0 * middle)
                        bend = ti.Vector([wide[0], wide[1], twist]) / (2.0 * dx) ** 2
                        for a in ti.static(range(2)):
                            cells.ground[c, a] = ti.cast(s[a], real)
                        for a in ti.static(range(3)):
                            cells.ground[c, 2 + a] = ti.cast(bend[a], real)
                        cells.ground[c, 5] = ti.cast(1.0 / ti.sqrt(1.0 + s.dot(s)), real)

    return shape

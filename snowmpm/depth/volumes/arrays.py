"""What the kernels of finite volumes take, in groups (`compiler.groups`), and the numbers of their tables."""

from typing import NamedTuple

from snowmpm.compiler.groups import Array, Real

TILE = 8
"""Cells along the side of a tile; tiles without snow, and none near, are left out."""

DRY = 1e-5
"""Depth [m] below which a cell has no velocity, and so little as is not left behind."""

LEAST_DEPTH = 1e-3
"""Depth [m] below which friction takes a cell for this deep, as of columns (`depth.gather`)."""

REPORT = 5
RATE, WORK, SPEED2, TAKEN_UP, HEIGHT = 0, 1, 2, 3, 4
"""Numbers of a tile's report: largest sum of |w| + c along both axes over dx [1/s], work of friction over density and
area of a cell [m3/s2], largest speed squared, snow cover taken up [kg], and its sum of mass times height [kg m]."""

GROUND = 6
"""Numbers of the ground in a cell: s (2), B over four cells (3: xx, yy, xy), cos."""

HELD, DRIVEN = 1, 2
"""Of a cell: held by friction; set in motion, or kept in it, by more than friction takes in a half step, which must not
stop it on the way."""

SLOPES, FLUX = 6, 4
"""Numbers of the slopes of a cell: of H, u, v along x, then along y; of a flux: mass, momentum across and along the
face, pressure."""


class Cells(NamedTuple):
    """Of all cells, those beyond the sides included, row after row of `ny`: state (n, 3) of H, u, v; held (n,): 0, HELD
    or DRIVEN; share (n,): of what would flow out of it in the step, how much there is;
    ahead (n, 3): half a step later; slopes (n, 6); flux (n, 2, 4) of the faces towards +x and +y; ground (n, 6)."""

    state: Array
    held: Array
    share: Array
    ahead: Array
    slopes: Array
    flux: Array
    ground: Array


class Friction(NamedTuple):
    """node (n,): number of each cell's node in the plan grid, place (nodes,): its row in numbers; rho [kg/m3]."""

    node: Array
    place: Array
    numbers: Array
    rho: Real


class Tiles(NamedTuple):
    """live (tiles,): whether there is snow in or near; their number, rows of them along y, cells along x and y."""

    live: Array
    n: int
    rows: int
    nx: int
    ny: int


class Step(NamedTuple):
    """dt [s]; dx [m]; g [m/s2]; share of the centrifugal term that counts."""

    dt: Real
    dx: Real
    g: Real
    centrifugal: Real

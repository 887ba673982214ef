"""What the kernels of the powder layer take, in groups (`compiler.groups`), and the numbers of their tables."""

from typing import NamedTuple

from snowmpm.compiler.groups import Array, Double

STATE, SLOPES, FLUX, PEAKS = 4, 10, 6, 5
"""Numbers of a cell: V, I, M_x, M_y; slopes of V, c, u, v along x, then along y, and differences of V over two cells
along x and y; of a flux: volume, ice, momentum (2) less the pressure in the cell before the face, and less that in the
cell beyond, each in the plane of this cell; of peaks: height, pressure of the means, pressure at the foot, speed,
density."""

REPORT = 12
RATE, AIR, ADDED, PULL, FACES, DRAG = 0, 1, 2, 3, 6, 9
"""Numbers of a tile's report of a step: largest sum over both axes of signal speed over dx [1/s]; volume of air taken
in, volume that kept a cell from running below empty, both over the area of a cell [m]; momentum (3) over the area of a
cell [kg/m/s] by weight, by what crossed faces, by drag of ground and air."""

PASSING = 15
UP, DOWN, LAID, TO_CORE, TO_GROUND, WORK, LIFT, DISPERSED, DUST, FASTEST, COVER = 0, 1, 2, 3, 6, 9, 10, 11, 12, 13, 14
"""Numbers of a tile's report of an exchange, over the area of a cell: ice from the flow to the cloud, back, and to the
ground [kg/m2]; momentum (3) that the flow got, and that ground and air got; kinetic and potential energy that the flow
got [J/m2]; air of a cloud that dispersed [m], and its ice [kg/m2]; RATE of a step; ice from the snow cover [kg/m2]."""


class Cloud(NamedTuple):
    """Of all cells, those beyond the sides included, row after row of `ny`: state (n, 4), that at the start of the step
    `first` (n, 4), slopes (n, 10), flux (n, 2, 6) of the faces towards +x and +y, peaks (n, 5) so far; laid and cover
    (n,) [kg/m2 in plan]: ice on the ground, and snow that may be taken up; own (n,): whether a cell lies within the
    sides and has ground."""

    state: Array
    first: Array
    slopes: Array
    flux: Array
    peaks: Array
    laid: Array
    cover: Array
    own: Array


class Below(NamedTuple):
    """The flow: state (nx, ny, 3) of H, u, v; ground (nx, ny, 6) as of `depth.volumes.arrays.GROUND`; heights (nx, ny)
    [m]; rho_1 [kg/m3]."""

    state: Array
    ground: Array
    heights: Array
    rho: Double


class Tiles(NamedTuple):
    """live (tiles,): whether there is cloud in or near; their number, rows of them along y, cells along x and y."""

    live: Array
    n: int
    rows: int
    nx: int
    ny: int


class Step(NamedTuple):
    """dt [s]; dx [m]; g [m/s2]; 0 in the first stage, 1 in the second."""

    dt: Double
    dx: Double
    g: Double
    stage: int


class Numbers(NamedTuple):
    """rho_a, rho_i - rho_a, rho_i [kg/m3]; factors <cu>, <uu>, <cuu>, and of u^2 and c u^2 at the foot; drags of the
    ground, between the layers, of the top, of the front; fall speed [m/s]; rate and stress of the suspension, and of
    what takes the snow cover up."""

    air: Double
    excess: Double
    ice: Double
    cu: Double
    uu: Double
    cuu: Double
    foot_uu: Double
    foot_cuu: Double
    ground_drag: Double
    core_drag: Double
    top_drag: Double
    front_drag: Double
    fall: Double
    rate: Double
    stress: Double
    cover_rate: Double
    cover_stress: Double

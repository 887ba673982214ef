"""Snow on the ground around an avalanche: what it covers, and when the flow swept each place bare."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from snowmpm.errors import InputError
from snowmpm.render import light
from snowmpm.render.colour import scalar

GROUNDS = ("auto", "winter", "summer")
COVER = light.decode([0.82, 0.845, 0.88])  # darker than snow that was just broken up, or that would not be told from it
STEEP = (46.0, 8.0)  # degrees: slope from which snow lies in patches, and until none does; a grain shifts it
PATCHES = 14.0  # degrees of that shift
DENSEST = 700.0  # kg/m3: what is denser is no snow
SMALLEST = 20.0  # m: ground of a smaller extent is that of a laboratory or a saw test
SAMPLED_FRAMES = 60
SAMPLED_POINTS = 30000  # of a frame
SUBSTEPS = 12  # places at most on the way of a particle between two of these frames
MOVING = 0.02  # share of the largest speed: less counts as rest
LYING = 2.5  # spacings above the ground, and a cell for its slope, up to which snow lies on it
WHOLE = 0.35  # of a layer of particles, from which the ground below counts as covered
RAGGED = 0.9  # cells by which the rim of the track wanders


@dataclass(frozen=True)
class SnowCover:
    """Snow on a relief.

    swept (rows, columns): time [s] at which moving snow first was in each cell, inf: never
    heights (rows, columns): of the ground [m]
    x0, y0, cell [m]: as of the relief (`relief.Relief`)
    """

    swept: np.ndarray
    heights: np.ndarray
    x0: float
    y0: float
    cell: float

    @classmethod
    def of(cls, run, relief, spacing):
        """The cover of the ground of a `Run` whose particles are `spacing` [m] apart; where they rest it is not swept.

        Between the frames looked at, particles are taken to have moved with the velocity at the end of the interval.
        """
        swept = np.full(relief.heights.shape, np.inf)
        for times, points in reversed(_on_the_way(run, relief.cell)):
            column = np.round((points[:, 0] - relief.x0) / relief.cell).astype(int)
            row = np.round((points[:, 1] - relief.y0) / relief.cell).astype(int)
            inside = (row >= 0) & (row < swept.shape[0]) & (column >= 0) & (column < swept.shape[1])
            # From the latest time to the earliest: what is written last stays
            swept[row[inside], column[inside]] = times[inside]
        # Gaps between particles belong to the track, strays do not
        reach = 2 * int(np.ceil(1.5 * spacing / relief.cell)) + 1
        swept = ndimage.grey_opening(swept, size=(max(reach, 3),) * 2, mode="nearest")
        swept = ndimage.grey_closing(swept, size=(3, 3), mode="nearest")
        return cls(swept, relief.heights, relief.x0, relief.y0, relief.cell)

    def cells(self, places):
        """(rows, columns) (2, n) of the cells with places (n, 3)."""
        at = np.stack([(places[:, 1] - self.y0) / self.cell, (places[:, 0] - self.x0) / self.cell])
        return np.round(at).astype(np.int32).clip(0, np.reshape(self.swept.shape, (2, 1)) - 1)

    def left(self, points, spacing):
        """Share (rows, columns) of each cell that snow at `points` (n, 3), a `spacing`, one or (n,), apart [m], covers.

        Gaps that the grid of the run does not resolve are not bare ground: a layer of snow that is thinner than the
        particles are apart is drawn as some of them on a dusted floor.
        """
        row, column = self.cells(points)
        spacing = np.broadcast_to(spacing, len(points))
        lying = points[:, 2] < self.heights[row, column] + LYING * spacing + self.cell
        number = row[lying] * self.swept.shape[1] + column[lying]
        layers = np.bincount(number, (spacing[lying] / self.cell) ** 2, self.swept.size).reshape(self.swept.shape)
        width = 2.0 * float(np.median(spacing)) / self.cell if len(points) else 0.0
        return (ndimage.gaussian_filter(layers, max(width, 0.7)) / WHOLE).clip(0.0, 1.0)

    def over(self, bare, grain, normal):
        """Colours (n, 3) of covered ground from those of bare ground, its grain (n,) in [0, 1] and normals (n, 3)."""
        slope = np.degrees(np.arccos(np.clip(normal[:, 2], -1.0, 1.0)))
        begin, width = STEEP
        share = np.clip((begin + width - slope + PATCHES * (grain - 0.5)) / width, 0.0, 1.0)[:, None]
        return bare + share.astype(np.float32) * (COVER * (0.97 + 0.06 * grain[:, None]) - bare)

    def when(self, places):
        """Time [s] (n,) at which places (n, 3) on the ground were swept, inf where never; the rim is ragged."""
        shift = RAGGED * (_noise(places, 3.0 * self.cell) + 0.6 * _noise(places, 0.9 * self.cell))
        rows, columns = self.swept.shape
        row = np.round((places[:, 1] - self.y0) / self.cell + shift).astype(int).clip(0, rows - 1)
        column = np.round((places[:, 0] - self.x0) / self.cell - shift).astype(int).clip(0, columns - 1)
        return self.swept[row, column].astype(np.float32)


def snow_cover(run, relief, spacing, ground="auto"):
    """The `SnowCover` of the ground of a run, or None for ground without snow.

    ground: "winter", "summer", or "auto": winter where snow moves on a slope outdoors, by the densities of the run's
    materials and the extent of the relief. Raises InputError for another word.
    """
    if ground not in GROUNDS:
        raise InputError.not_in("ground", ground, GROUNDS)
    if relief is None or ground == "summer" or (ground == "auto" and not (_outdoors(relief) and _of_snow(run))):
        return None
    return SnowCover.of(run, relief, spacing)


def _outdoors(relief):
    extent = relief.cell * max(relief.heights.shape)
    return extent >= SMALLEST and np.nanmax(relief.heights) - np.nanmin(relief.heights) > 0.05 * extent


def _of_snow(run):
    """Whether all that a run has particles of is as light as snow; not known of a file without its scene."""
    if not isinstance(run.provenance.get("scene"), str):
        return False
    materials = run.scene.get("materials") or {}
    densities = [one.get("density") for one in materials.values()]
    return bool(densities) and all(isinstance(rho, int | float) and rho < DENSEST for rho in densities)


def _on_the_way(run, cell):
    """[(times (k,), places (k, 2))] of moving particles at some frames, in the order of time, and on the way to each
    since the one before, in the reverse order; empty without velocities."""
    if "velocity" not in run.field_names:
        return []
    frames = np.unique(np.linspace(0, len(run) - 1, SAMPLED_FRAMES).round().astype(int))
    seen = [_sampled(run, int(i)) for i in frames]
    fastest = max((float(np.quantile(speed, 0.99)) for *_, speed in seen if len(speed)), default=0.0)
    found = []
    for k, (time, points, velocity, speed) in enumerate(seen):
        moving = speed > MOVING * fastest
        if not moving.any() or fastest <= 0.0:
            continue
        since = time - seen[k - 1][0] if k else 0.0
        steps = int(np.clip(np.ceil(float(speed[moving].max()) * since / (1.5 * cell)), 1, SUBSTEPS))
        back = since * np.arange(steps) / steps
        plan, pace = points[moving, :2], velocity[moving, :2]
        places = (plan - back[:, None, None] * pace).reshape(-1, 2)
        found.append((np.repeat(time - back, len(plan)), places))
    return found


def _sampled(run, i):
    """(time, points, velocities, speeds) of some particles of frame `i`."""
    frame = run.frame(i, ["velocity"])
    some = slice(None, None, max(1, len(frame.points) // SAMPLED_POINTS))
    points, velocity = frame.points[some].astype(float), frame.fields["velocity"][some]
    good = np.isfinite(points).all(axis=1) & np.isfinite(velocity).all(axis=1)
    return frame.time, points[good], velocity[good], scalar(velocity[good])


def _noise(places, size):
    """Fixed noise in [-1, 1] over plan positions, in patches of a `size` [m]."""
    table = np.random.default_rng(5).uniform(-1.0, 1.0, (256, 256)).astype(np.float32)
    at = np.stack([places[:, 1], places[:, 0]]) / size
    return ndimage.map_coordinates(table, at, order=1, mode="grid-wrap")

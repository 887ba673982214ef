"""What the pictures of one film share: the snow of a frame, its colours, its words."""

import numpy as np
from scipy.spatial import cKDTree

from snowmpm.io.parameters import methods_of
from snowmpm.io.status import cautions
from snowmpm.render import light
from snowmpm.render.colour import choose_scale
from snowmpm.render.floor import ground_of
from snowmpm.render.fracture import NAME as FRACTURE
from snowmpm.render.fracture import WeakLayer
from snowmpm.render.quality import Quality
from snowmpm.render.saw_blade import SawBlade
from snowmpm.render.sheet import sheet_of
from snowmpm.render.snow import SNOW
from snowmpm.render.solid import placed
from snowmpm.render.timing import pace_in_words
from snowmpm.render.upright import turned


class View:
    """What the pictures of one film share: colours, particle size, words."""

    def __init__(self, run, size, color):
        self.run, self.size = run, size
        self.cut = None
        self.colour_by(color)
        self.spacing = particle_spacing(run)
        self.title, self.cautions = run.name, cautions(run)
        self.pace, self.plain, self.layer_drawn = None, False, "picture"
        self.quality, self.as_sheet = Quality(), False
        self.terrain, self.saw = ground_of(run), SawBlade.of(run)

    def colour_by(self, color):
        """Choose the colours of the snow: as of `view_of`."""
        self.layer = WeakLayer.of(self.run) if color == FRACTURE else None
        self.scale = self.layer.scale() if self.layer else choose_scale(self.run, color)
        self.table = None if self.scale is None else light.decode(self.scale.table())

    @property
    def most_points(self):
        """Particles of the fullest frame."""
        return max(self.run.n_points(i) for i in range(len(self.run)))

    def fields_of(self, i):
        """Frame `i` with the fields that its colours need."""
        names = [] if self.scale is None else [self.scale.field]
        names += ["material"] if self.layer or self.cut else []
        names += ["depth"] if "depth" in self.run.field_names else []
        known = "id" in self.run.field_names
        return self.run.frame(i, dict.fromkeys([*names, *(["id"] if known else [])]))

    def _frame(self, i):
        """(time, what the drawing functions take of frame `i`: points, spacing, colours, identity)."""
        frame = self.fields_of(i)
        good = np.isfinite(frame.points).all(axis=1)
        thin = 1 if "depth" in frame.fields or self.run.dimension == 2 else self.quality.share(self.most_points)
        if thin > 1:
            # The same ones in every frame, where they are known
            good &= frame.fields.get("id", np.arange(len(good))) % thin == 0
        if self.cut:
            good &= self.cut.shown(frame)
        colours = None
        if self.layer:
            colours = self.layer.colours(frame, self.table, SNOW)[good]
        elif self.scale is not None:
            share = np.nan_to_num(self.scale.share(self.scale.numbers(frame)[good]))
            colours = self.table[np.round(255 * share).astype(int)]
        identity = frame.fields["id"][good] if "id" in frame.fields else None
        points = frame.points[good]
        spacing = particle_spacing(self.run, frame.time) * thin ** (1.0 / 3.0)
        if "depth" in frame.fields and len(points):
            depth, fine = frame.fields["depth"][good], self.run.provenance.get("zone_spacing")
            # Particles in three dimensions, before or after a hand-over, have a depth of zero
            if self.as_sheet and fine is None and np.mean(depth > 0.0) > 0.5:
                shown = np.tile(SNOW, (len(points), 1)) if colours is None else colours
                sheet = sheet_of(points, np.nan_to_num(depth.ravel()), spacing, shown, self.relief.height)
                if sheet is not None:
                    return frame.time, (*sheet, None)
            each = None if fine is None else np.where(depth.ravel() > 0.0, spacing, min(spacing, fine))
            points, colours, identity, each = piled(points, depth, spacing, colours, identity, each)
            spacing = spacing if each is None else each
        return frame.time, (points, spacing, colours, identity)

    near = 1.0
    """The side (1, -1) of y that the camera stands on, and the handle of a saw."""

    def solids(self, i):
        """Vertices (n, 3) [m] and facets of obstacles and saw in frame `i`."""
        solids = [placed(self.run, i)]
        if self.saw:
            vertices, facets = self.saw.placed(float(self.run.times[i]), self.near)
            solids.append((turned(self.run, vertices), facets + len(solids[0][0])))
        vertices, facets = zip(*solids, strict=True)
        return np.concatenate(vertices), np.concatenate(facets)

    def _point_at_saw(self, overlay, camera, time):
        """Words where the saw is."""
        if self.saw:
            place, words = self.saw.label(time, self.near)
            x, y, _ = camera.project(turned(self.run, place[None]))
            # On the side of the ground, where that rises
            rise = turned(self.run, np.array([[1.0, 0.0, 0.0]]))[0] @ [0.0, 0.0, 1.0]
            overlay.pointer((float(x[0]), float(y[0])), words, "la" if rise > 0.0 else "ra" if rise < 0.0 else "ma")

    def _legend(self, overlay, time, side="right"):
        overlay.heading(self.title.replace("_", " "), time, float(self.run.times[-1]), pace_in_words(self.pace))
        if time == self.run.times[-1]:
            overlay.warnings(self.cautions, "left" if side == "right" else "right")
        if self.scale is not None:
            overlay.colour_scale(self.scale, side)


def piled(points, depth, spacing, *others):
    """Columns of snow as piles of points: points (n, 3) at half their depth (n,) [m], in layers at most `spacing` [m]
    apart from the ground to the surface; -> (points, others), each layer with all rows of the others.

    Depths are normal to the ground, of which a frame does not know the slope: they are drawn upwards.
    """
    layers = 1 + int(np.ceil(np.nan_to_num(depth).max(initial=0.0) / spacing))
    if layers == 1:
        return points, *others
    at = np.linspace(-0.5, 0.5, layers)
    piles = np.tile(points.astype(float), (layers, 1))
    piles[:, 2] += (at[:, None] * np.nan_to_num(depth)).ravel()
    return piles, *(None if other is None else np.concatenate([other] * layers) for other in others)


def particle_spacing(run, time=0.0):
    """Distance [m] between particles: what the run says of itself, of its method at a time [s], or from the field
    `volume`, or between neighbours in the first frame that has any."""
    noted = run.provenance.get("particle_spacing")
    for record in methods_of(run):
        if record["time"] < time:
            noted = record["particle_spacing"]
    if isinstance(noted, int | float) and noted > 0.0:
        return float(noted)
    i = next(i for i in range(len(run)) if run.n_points(i))
    if "volume" in run.field_names:
        volume = float(np.median(run.frame(i, ["volume"]).fields["volume"]))
        if volume > 0.0:
            return volume ** (1.0 / run.dimension)
    points = run.frame(i, []).points
    points = points[np.isfinite(points).all(axis=1)]
    sample = points[np.random.default_rng(0).permutation(len(points))[:2000]]
    nearest = cKDTree(points).query(sample, k=2)[0][:, 1] if len(points) > 1 else np.array([1.0])
    nearest = nearest[np.isfinite(nearest) & (nearest > 0.0)]
    return float(np.median(nearest)) if len(nearest) else 1.0

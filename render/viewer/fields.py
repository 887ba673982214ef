"""What an interactive page can colour its snow by: some fields of the run, each on its scale."""

from dataclasses import dataclass

import numpy as np

from snowmpm.render.colour import ColourScale, choose_scale

MOST = 5
ORDER = ("velocity", "depth", "density", "damage", "material", "p", "q", "p0", "plastic_strain", "saturation")
WITHOUT = {"id", "volume", "mass", "J"}
PLAIN = [243, 247, 252]


@dataclass(frozen=True)
class Field:
    """A scale and, of the weak layer's, the layer."""

    scale: ColourScale
    layer: object = None

    @property
    def needs(self):
        """Names of the fields of a frame that it reads."""
        return [self.scale.field, *(["material"] if self.layer else [])]

    def share(self, frame):
        """Position (n,) of the particles of a frame on the map, in [0, 1]."""
        share = np.nan_to_num(self.scale.share(self.scale.numbers(frame)))
        if self.layer:  # all but the weak layer is as sound
            share = np.where(frame.fields["material"] == self.layer.weak, share, 0.0)
        return share

    def head(self):
        """What the page has to know of it."""
        scale = self.scale
        return {"title": scale.title, "low": scale.low, "high": scale.high,
                "names": [name.replace("_", " ") for name in scale.names],
                "table": np.round(255 * scale.table()).astype(int).ravel().tolist()}


def fields_of(view):
    """The field of a `run_film` view first, then others that the run has, in ORDER and by name, MOST in all."""
    run = view.run
    found = [] if view.scale is None else [Field(view.scale, view.layer)]
    names = [name for name in ORDER if name in run.field_names]
    names += sorted(set(run.field_names) - set(ORDER) - WITHOUT)
    drawn = {field.scale.field for field in found if field.layer is None}
    if "material" in names and len(run.provenance.get("materials", [])) < 2:
        names.remove("material")
    found += [Field(choose_scale(run, name)) for name in names if name not in drawn]
    return found[:MOST]

"""How carefully pictures are drawn: for showing, or quickly, to see whether time, colours and camera are right."""

from dataclasses import dataclass, replace

import numpy as np
from PIL import Image

from snowmpm.errors import InputError

ENOUGH = 60_000
"""Particles that are drawn of a run in any case, if it has as many."""


@dataclass(frozen=True)
class Quality:
    """coarse: pixels of the picture each way for one that is drawn; thinnest: in 3-D, every so manieth particle is
    drawn at most; crumbs: whether loose particles are taken apart (`crumble`)."""

    coarse: int = 1
    thinnest: int = 1
    crumbs: bool = True

    @classmethod
    def named(cls, name):
        """Raises InputError for another name than those of QUALITIES."""
        if name not in QUALITIES:
            raise InputError.not_in("quality", name, QUALITIES)
        return QUALITIES[name]

    def camera(self, camera):
        """The view of a `Camera` on the picture that is drawn, whose edges lie less than a pixel beyond."""
        if self.coarse == 1:
            return camera
        size = tuple(-(-side // self.coarse) for side in camera.size)
        return replace(camera, scale=camera.scale / self.coarse, size=size)

    def enlarged(self, picture, size):
        """A drawn picture (rows, columns, 3) uint8 at `size` (width, height)."""
        if self.coarse == 1:
            return picture
        rows, columns = picture.shape[:2]
        width, height = (side / self.coarse for side in size)
        box = (0.5 * (columns - width), 0.5 * (rows - height), 0.5 * (columns + width), 0.5 * (rows + height))
        return np.asarray(Image.fromarray(picture).resize(size, Image.Resampling.BILINEAR, box))

    def share(self, particles):
        """Every how manieth particle is drawn of a run with so many."""
        return int(np.clip(particles // ENOUGH, 1, self.thinnest))


QUALITIES = {"full": Quality(), "preview": Quality(coarse=3, thinnest=4, crumbs=False)}

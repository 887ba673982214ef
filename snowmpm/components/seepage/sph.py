"""Water that seeps, in a solver of its own (`.solver`) in place of that of SPH."""

from snowmpm.components.seepage.waters import SeepingWaters
from snowmpm.water.phases_from_scene import phases


def adapter(model):
    """`SeepingWaters` of a `Model`."""
    return phases(model, SeepingWaters)

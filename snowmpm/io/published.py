"""What stands beside published numbers: what they are, and to what they are known."""

from snowmpm.io.parameters import friction_of
from snowmpm.quantities.powder import EXPERIMENT
from snowmpm.quantities.resolution import resolutions


def statement(run):
    """In a sentence or two: the result of which model, with which friction and its calibration; no assessment of a
    hazard; whether an experiment is in it."""
    version = run.provenance.get("version")
    program = f"snowmpm {version}" if version else "snowmpm"
    return " ".join([f"Result of a model ({program}; {friction_of(run)}). No hazard assessment.", *experiments(run)])


def experiments(run):
    """A sentence if some map of a run is an experiment; none otherwise."""
    names = [name for name in run.maps if name.endswith(EXPERIMENT)]
    if names:
        yield f"Maps whose names end in {EXPERIMENT} are experiments: no measurement was compared with them."


def resolution_of(run):
    """{name: resolution} of the numbers of hazard mapping of a `Run`; {} without maps."""
    raster = run.maps.get("peak_depth")
    if raster is None:
        return {}
    return resolutions(run.hazard.get("numbers", {}), max(raster.cell, float(run.provenance.get("dx") or 0.0)))

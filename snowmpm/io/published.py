"""What stands beside published numbers: what they are, and to what they are known."""

from snowmpm.io.parameters import friction_of
from snowmpm.quantities.resolution import resolutions


def statement(run):
    """In a sentence: the result of which model, with which friction and its calibration; no assessment of a hazard."""
    version = run.provenance.get("version")
    program = f"snowmpm {version}" if version else "snowmpm"
    return f"Result of a model ({program}; {friction_of(run)}). No hazard assessment."


def resolution_of(run):
    """{name: resolution} of the numbers of hazard mapping of a `Run`; {} without maps."""
    raster = run.maps.get("peak_depth")
    if raster is None:
        return {}
    return resolutions(run.hazard.get("numbers", {}), max(raster.cell, float(run.provenance.get("dx") or 0.0)))

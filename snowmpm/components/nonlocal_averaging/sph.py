"""The average in SPH."""

from snowmpm.components.nonlocal_averaging.average import FadingAverage


def adapter(model):
    """`FadingAverage` of the materials of a `Model`."""
    return FadingAverage(model.laws)

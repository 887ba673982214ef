"""The average in explicit MPM."""

from snowmpm.components.nonlocal_averaging.average import FadingAverage


def adapter(model):
    """`FadingAverage` of the materials of a `Model`."""
    return FadingAverage(model.laws)

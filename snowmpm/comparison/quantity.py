"""A number measured on a run, and its reference value."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """name, unit, measured; low, high: reference band from an experiment or a formula."""

    name: str
    unit: str
    measured: float
    low: float
    high: float

    @classmethod
    def exact(cls, name, unit, measured, known):
        """A quantity whose reference is one number."""
        return cls(name, unit, float(measured), float(known), float(known))

    @property
    def error(self):
        """Relative distance from the band, 0 inside, negative below it [-]."""
        if self.low <= self.measured <= self.high:
            return 0.0
        near = self.low if self.measured < self.low else self.high
        return (self.measured - near) / abs(near) if near else float("inf")

"""What acts on the snow beside contact and stress: gravity over time, accelerations, pressures, damping."""

from snowmpm.forcing.forcing import Forcing

__all__ = ["Forcing"]

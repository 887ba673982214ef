"""Forces in steps that are solved for."""

from snowmpm.components.forcing_and_damping.acting import adapter

__all__ = ["adapter"]

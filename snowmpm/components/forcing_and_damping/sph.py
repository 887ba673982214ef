"""Forces in SPH."""

from snowmpm.components.forcing_and_damping.acting import adapter

__all__ = ["adapter"]

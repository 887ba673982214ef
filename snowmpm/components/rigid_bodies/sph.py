"""Bodies in SPH."""

from snowmpm.components.rigid_bodies.acting import adapter

__all__ = ["adapter"]

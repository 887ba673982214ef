"""Structures in SPH."""

from snowmpm.components.structures.acting import adapter

__all__ = ["adapter"]

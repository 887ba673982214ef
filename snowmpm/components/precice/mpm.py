"""Structures of another program in explicit MPM: they stand in the snow as all others, with the steps of `.windows`."""

from snowmpm.components.precice.windows import adapter

__all__ = ["adapter"]

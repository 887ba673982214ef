"""The snow cover under a flow by finite volumes: what columns have, by `depth.intake`."""

from snowmpm.components.entrainment.depth import adapter

__all__ = ["adapter"]

"""Particles at the start: shapes, layers on the terrain, release regions."""

from snowmpm.seeding.body import Seeds, seed_body

__all__ = ["Seeds", "seed_body"]

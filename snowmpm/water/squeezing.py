"""How soft water may be, of schemes that squeeze it."""

SQUEEZED, ENOUGH = 0.02, 100.0
"""Compression of water that is told, and its stiffness over the largest pressure that is enough."""

"""Accelerations, pressures and damping on all snow, and gravity that changes."""

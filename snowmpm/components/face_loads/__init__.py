"""Tractions, pressures and prescribed motions of parts of the surface of bodies (docs/surface_loads.md)."""

"""Particles to grid and back: splines, stencils, scatter, gather."""

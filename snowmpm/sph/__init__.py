"""Finite-strain smoothed particle hydrodynamics on the laws, particles, terrain and obstacles of the program."""

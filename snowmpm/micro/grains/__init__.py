"""Grains: the discrete element method for spheres with friction, rolling resistance and bonds."""

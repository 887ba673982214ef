"""Propagation saw test: the saw, measurements during the run, and theories for comparison."""

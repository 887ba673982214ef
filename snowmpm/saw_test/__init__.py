"""Propagation saw test: the saw, what is measured while the crack runs, and theories to hold it against."""

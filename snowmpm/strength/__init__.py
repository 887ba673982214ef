"""Strength reduction: how much weaker the material of a slope could be and still stand."""

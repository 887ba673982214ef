"""Grains and water with a velocity each, in explicit MPM."""

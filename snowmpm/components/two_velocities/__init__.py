"""Grains and water with a velocity each."""

"""Rigid bodies with mass, which snow, weight and contact move."""

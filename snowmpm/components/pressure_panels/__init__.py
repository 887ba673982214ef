"""Pressure of the snow over the face of an obstacle, panel by panel and in time."""

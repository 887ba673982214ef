"""Definitions of the numbers of a run: one definition per name, with unit and digits. Needs only NumPy."""

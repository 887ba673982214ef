"""What the numbers of a run mean: one definition a name, with its unit and digits. Needs NumPy only."""

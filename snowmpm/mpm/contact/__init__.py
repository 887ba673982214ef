"""The grid at walls, obstacles and other bodies."""

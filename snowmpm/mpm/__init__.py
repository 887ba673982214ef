"""The material point method: particles to grid, grid, grid to particles."""

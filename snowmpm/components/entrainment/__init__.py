"""Snow cover that a depth-averaged flow takes up."""

"""Depth-averaged flow by finite volumes: the second scheme of `solver.method = "depth"`, on the cells of a grid."""

"""The cheapest models of run-out: statistics of a path, an energy line, a block on a path, routing over a raster."""

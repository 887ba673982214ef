"""Layers of snow thinner than a cell, between rigid ground and the snow above, carried by points of their own."""

"""Depth-averaged flow: columns of snow that move in plan over the ground."""

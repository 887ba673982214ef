"""A run as an interactive page, in one HTML file that loads nothing: the scene in three dimensions, turned by hand."""

from snowmpm.render.viewer.scene import SCRIPTS, render_page, viewer

__all__ = ["SCRIPTS", "render_page", "viewer"]

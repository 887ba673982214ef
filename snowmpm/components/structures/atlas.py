"""Entries of masts and frameworks."""

from snowmpm.components.structures import framework_atlas, mast_atlas

ATLAS = {"bodies and structures": (*mast_atlas.ENTRIES, *framework_atlas.ENTRIES)}

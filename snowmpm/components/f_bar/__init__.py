"""One change of volume, or one deformation, for all particles of a cell (F-bar), against volumetric locking."""

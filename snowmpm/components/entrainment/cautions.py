"""Rule: covers that a flow in space can fracture and shear."""

from snowmpm.advice.cautions.caution import Caution, rule

MOST = 2.0
"""Cells through a cover above which a body of its own shows more."""


@rule("mpm")
def thick_cover(facts):
    """A cover that the grid resolves."""
    terrain = facts.scene.terrain
    cover = terrain and terrain.get("entrainment")
    if cover and isinstance(cover.thickness, int | float):
        cells = cover.thickness / facts.dx
        if cells > MOST * (1.0 + 1e-9):
            says = f"a cover of {cells:.2g} cells is taken up from the bed, and neither fractures nor is ploughed up"
            yield Caution("", "terrain.entrainment.thickness", says,
                          "a body with laid_ahead in its place (snowmpm docs snow_cover)")

"""Output for geographic information systems: outlines, lines and points of a run, styles, a project; scores against
an observed outline (`snowmpm.gis.observed`). Reads run files; needs the `gis` extra."""

from snowmpm.gis.layers import layers_of
from snowmpm.gis.qgis_project import write_project
from snowmpm.gis.qgis_style import vector_style, write_style, write_style_of_shares
from snowmpm.gis.tables import write_areas, write_numbers, write_record
from snowmpm.gis.temporal import Moment
from snowmpm.gis.vectors import require_pyogrio, write_geojson, write_geopackage

__all__ = ["Moment", "layers_of", "require_pyogrio", "vector_style", "write_areas", "write_geojson", "write_geopackage",
           "write_numbers", "write_project", "write_record", "write_style", "write_style_of_shares"]

"""Names and shapes inside a run file, common to writer and reader.

A run file is a VTKHDF temporal PolyData (version 2.0) plus groups that VTK ignores::

    VTKHDF/                    Type = "PolyData", Version = (2, 0)
        NumberOfPoints         (steps,) points of each step
        Points                 (rows, 3) float64 [m], map coordinates; in version 1 float32, relative to `origin`
        PointData/<field>      (rows,), (rows, 3) or (rows, 6); attribute `units`
        Vertices/              one cell a particle: 0, 1, 2, ... written once, shared by all steps
        Lines/ Strips/ Polygons/   empty, but VTK wants them
        Steps/                 Values [s], PointOffsets, PointDataOffsets/<field>, ...; attribute NSteps
    history/<name>             (rows,) float64; attribute `units`; `time` is one of them
    terrain/vertices, facets   (n, 3) float64 [m] relative to `origin`; (m, 3) triangles or (m, 2) segments
    obstacles/<name>/          if any: vertices, facets as of the terrain, where the scene draws it
        rotation, translation  (steps, 3, 3), (steps, 3) [m]: in step i it is at rotation x + translation
        time, force, moment, impulse, work   loads by the snow, finer than the steps; attribute `units`
    surroundings/<block>/      terrain, obstacle_NAME: temporal PolyData in map coordinates (`snowmpm.io.surroundings`)
    saw_test/                  if it is one; attribute `about`, JSON
        time, saw, tip ...     (rows,), finer than the steps; settlement, slip ... (rows, bins); x, arrival ... (bins,)
    series/<kind>/<name>/      if a component records something: time (rows,), its columns (rows, ...); attribute
                               `about`, JSON (`snowmpm.io.series`)
    maps/<name>                (rows, columns) float32 rasters in plan; attributes x0, y0, cell, units
    provenance/record          JSON
    hazard/record              JSON: run-out, affected area, profile along the thalweg; of 3-D runs

Attributes of the file: `format` = "snowmpm", `format_version`, `dimension`, `origin`, `complete`. A plane-strain run
stores its points as (x, 0, z). Each step starts on a chunk boundary, so a chunk is written once and never moves: rows
between the end of one step and the start of the next are padding that no step refers to.
"""

FORMAT = "snowmpm"
FORMAT_VERSION = 2
"""2: points in map coordinates, and `surroundings`. 1 is still read, and continued as it is."""

RUN_FILE = "run.vtkhdf"
COMPANION_FILE = "paraview.vtkhdf"
"""Beside the run file: snow, terrain and obstacles as blocks of one data set."""

SUMMARY_FILE = "summary.json"

VTK_VERSION = (2, 0)
VTK_COMPOSITE_VERSION = (2, 1)
CELL_KINDS = ("Vertices", "Lines", "Strips", "Polygons")

# The 1.10 format indexes growing data sets by extensible arrays, which only ever gain entries: a reader that holds
# older metadata still finds every chunk it knows of. ParaView and VTK have read it since 2017.
HDF5_VERSIONS = ("v110", "v110")

SMALL_CHUNK_ROWS = 64
LARGE_CHUNK_ROWS = 65536

STORED_SHARE = {2: 0.6, 3: 0.75}
"""Ratio of compressed to raw size of particle data, by dimension of the scene (measured: 0.45 to 0.95)."""

OVERHEAD = 300_000
"""Approximate bytes of a run file without its particles."""


def expected_size(dimension, frames, particles, components):
    """Approximate bytes of a run file; components: numbers per particle in a frame, position included."""
    return int(OVERHEAD + STORED_SHARE[dimension] * 4 * components * particles * frames)


def chunk_rows(n_points):
    """Rows of one point-data chunk: a whole step if it is small, so that a step takes one chunk a field."""
    if n_points <= LARGE_CHUNK_ROWS:
        return max(int(n_points), SMALL_CHUNK_ROWS)
    return LARGE_CHUNK_ROWS // 2


def next_boundary(row, chunk):
    """First chunk boundary at or after `row`."""
    return -(-row // chunk) * chunk

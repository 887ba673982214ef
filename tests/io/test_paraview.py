"""Snow, terrain and obstacles as ParaView opens them: in map coordinates, in every step, also while the run goes on.

Read by VTK's own reader, the one that ParaView has.
"""

import numpy as np
import pytest

from snowmpm.io import Run, RunWriter

hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
from vtkmodules.util.numpy_support import vtk_to_numpy  # noqa: E402
from vtkmodules.vtkCommonCore import reference  # noqa: E402
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline  # noqa: E402

EAST, NORTH, HEIGHT = 2_602_183.37, 1_179_450.91, 2871.13
"""Somewhere in the Alps, in Swiss coordinates: float32 has steps of a quarter of a metre there."""
TIMES = [0.0, 0.25, 0.5]


def slope(x, y):
    """Height of the ground."""
    return 40.0 - 0.5 * x + 0.1 * y


@pytest.fixture(scope="module")
def snow():
    """Particles on a slope, relative to the origin, moving down it."""
    rng = np.random.default_rng(1)
    start = rng.uniform([5.0, 5.0], [40.0, 45.0], (500, 2))
    return [np.column_stack([start + np.array([10.0 * time, 0.0]), slope(start[:, 0] + 10.0 * time, start[:, 1])])
            for time in TIMES]


def write(path, frames, dimension=3, count=3):
    corners = np.array([[x, y, slope(x, y)] for x in (0.0, 60.0) for y in (0.0, 50.0)])
    gate = np.array([[50.0, 20.0, 10.0], [50.0, 30.0, 10.0], [50.0, 25.0, 25.0]])
    terrain, wall = (corners, [[0, 2, 1], [1, 2, 3]]), (gate, [[0, 1, 2]])
    axes = [0, 1, 2]
    if dimension == 2:
        axes = [0, 2]
        terrain, wall = (corners[[0, 2]][:, axes], [[0, 1]]), (gate[[0, 2]][:, axes], [[0, 1]])
    writer = RunWriter(path, provenance={}, terrain=terrain, obstacles={"gate": wall}, dimension=dimension,
                       origin=np.array([EAST, NORTH, HEIGHT])[axes], durable=False)
    for time, points in zip(TIMES[:count], frames, strict=False):
        lift = np.zeros(dimension)
        lift[-1] = 8.0 * max(time - 0.25, 0.0)  # at rest at first
        speed = np.full(len(points), time)
        writer.frame(time, points[:, axes], {"speed": speed}, {"gate": (np.eye(dimension), lift)})
    return writer


def blocks(path, time):
    """PolyData by name at a time of the data set, and the times it has.

    By the number of the step: the reader of VTK 9.7 misses a time that is asked for first, also in files of its own.
    """
    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    times = information.Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()) or [0.0]
    reader.SetStep(list(times).index(time))
    reader.Update()
    data = reader.GetOutputDataObject(0)
    names = [data.GetMetaData(i).Get(data.NAME()) for i in range(data.GetNumberOfBlocks())]
    return {name: data.GetBlock(i) for i, name in enumerate(names)}, list(times)


def points_of(block):
    return vtk_to_numpy(block.GetPoints().GetData())


def test_particles_lie_on_the_terrain_in_map_coordinates(tmp_path, snow):
    from vtkmodules.vtkCommonDataModel import vtkCellLocator

    write(tmp_path, snow).close()
    for time, relative in zip(TIMES, snow, strict=True):
        shown, times = blocks(tmp_path / "paraview.vtkhdf", time)
        assert times == TIMES and set(shown) == {"snow", "terrain", "obstacle_gate"}
        points = points_of(shown["snow"])
        assert points.dtype == np.float64
        assert np.abs(points - (relative + np.array([EAST, NORTH, HEIGHT]))).max() < 1e-5
        terrain = shown["terrain"]
        assert terrain.GetNumberOfPolys() == 2 and shown["snow"].GetNumberOfVerts() == len(points)
        locator = vtkCellLocator()
        locator.SetDataSet(terrain)
        locator.BuildLocator()
        closest, cell, part, squared = [0.0] * 3, reference(0), reference(0), reference(0.0)
        for point in points[::25]:
            locator.FindClosestPoint(point, closest, cell, part, squared)
            assert float(squared) < 1e-5**2
        assert np.array_equal(vtk_to_numpy(shown["snow"].GetPointData().GetArray("speed")), np.full(500, time, "f4"))


def test_an_obstacle_is_where_it_was_in_each_frame(tmp_path, snow):
    write(tmp_path, snow).close()
    run = Run(tmp_path)
    for i, time in enumerate(TIMES):
        shown = points_of(blocks(tmp_path / "paraview.vtkhdf", time)[0]["obstacle_gate"])
        assert np.allclose(shown, run.obstacles["gate"].placed(i) + run.origin, rtol=0.0, atol=1e-9)


def test_a_section_has_lines_of_terrain(tmp_path, snow):
    write(tmp_path, snow, dimension=2).close()
    shown, _ = blocks(tmp_path / "paraview.vtkhdf", 0.5)
    assert shown["terrain"].GetNumberOfLines() == 1 and shown["terrain"].GetNumberOfPolys() == 0
    assert points_of(shown["terrain"])[0].tolist() == [EAST, 0.0, HEIGHT + 40.0]
    assert np.allclose(points_of(shown["snow"]), Run(tmp_path).frame(2).positions, rtol=0.0, atol=1e-9)


def test_all_blocks_have_the_same_steps_while_the_run_goes_on(tmp_path, snow):
    for count in (1, 2, 3):
        writer = write(tmp_path, snow, count=count)
        shown, times = blocks(tmp_path / "paraview.vtkhdf", TIMES[count - 1])
        assert times == TIMES[:count] and shown["terrain"].GetNumberOfPolys() == 2
        writer.close()


def test_and_after_frames_were_dropped_and_written_anew(tmp_path, snow):
    write(tmp_path, snow).close()
    (tmp_path / "paraview.vtkhdf").unlink()  # comes back too
    with RunWriter.reopen(tmp_path, until=0.3, durable=False) as writer:
        writer.frame(0.4, snow[1], {"speed": np.ones(500)}, {"gate": (np.eye(3), np.array([0.0, 0.0, 7.0]))})
    shown, times = blocks(tmp_path / "paraview.vtkhdf", 0.4)
    assert times == [0.0, 0.25, 0.4]
    assert points_of(shown["obstacle_gate"])[0, 2] == pytest.approx(HEIGHT + 17.0, abs=1e-9)
    assert points_of(blocks(tmp_path / "paraview.vtkhdf", 0.25)[0]["obstacle_gate"])[0, 2] == HEIGHT + 10.0


def test_our_own_reader_sees_positions_in_map_coordinates(tmp_path, snow):
    write(tmp_path, snow).close()
    frame = Run(tmp_path).frame(1)
    assert np.array_equal(frame.points, snow[1].astype(np.float32))
    assert np.abs(frame.positions - (snow[1] + [EAST, NORTH, HEIGHT])).max() < 1e-5

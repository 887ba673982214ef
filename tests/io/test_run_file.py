"""What is written to a run file is what is read from it, by our reader and by VTK's own."""

import json

import h5py
import numpy as np
import pytest
from run_states import ORIGIN, UNITS, assert_whole, loads, n_points, new_writer, pose, state, write_frame

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter, layout

N = 1000


@pytest.fixture
def run_path(tmp_path):
    with new_writer(tmp_path) as writer:
        for i in range(6):
            write_frame(writer, i, N)
        writer.history(0.55, {"mass": 2.0, "energy": 7.0}, {"energy": "J"})
        writer.map("peak_depth", [[1.0, 2.0, np.nan]], x0=0.5, y0=1.5, cell=2.0, units="m")
        writer.provenance({"wall_time": 12.0})
    (tmp_path / "summary.json").write_text(json.dumps({"frames": 6}))
    return tmp_path


def test_frames_come_back_bit_for_bit(run_path):
    run = Run(run_path)
    assert len(run) == 6
    assert [run.n_points(i) for i in range(6)] == [n_points(i, N) for i in range(6)]
    assert_whole(run, N)
    assert np.array_equal(run.frame(-1).points, run.frame(5).points)
    assert list(run.frame(2, ["density"]).fields) == ["density"]


def test_everything_beside_the_frames_comes_back(run_path):
    run = Run(run_path / "run.vtkhdf")
    assert run.complete and run.dimension == 3
    assert np.array_equal(run.origin, [5.0e5, 2.0e5, 1.0e3])
    assert run.units == {**UNITS, "time": "s", "mass": "kg", "front": "m", "energy": "J"}
    assert run.history["time"].tolist() == [*(i * 0.1 for i in range(6)), 0.55]
    assert run.history["front"][:6].tolist() == [0, 1, 2, 3, 4, 5] and np.isnan(run.history["front"][6])
    assert np.isnan(run.history["energy"][:6]).all() and run.history["energy"][6] == 7.0
    assert run.terrain.vertices[2].tolist() == [0.0, 1.0, 0.5] and run.terrain.facets.tolist() == [[0, 1, 2]]
    assert run.provenance == {"scene": "made up", "seed": 1, "wall_time": 12.0}
    assert run.summary == {"frames": 6}
    assert run.name == run_path.name
    depth = run.maps["peak_depth"]
    assert (depth.x0, depth.y0, depth.cell, depth.units) == (0.5, 1.5, 2.0, "m")
    assert np.array_equal(depth.values, [[1.0, 2.0, np.nan]], equal_nan=True)


@pytest.mark.parametrize("dimension", [2, 3])
def test_obstacles_come_back_with_their_loads_and_where_they_were(tmp_path, dimension):
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]) if dimension == 2 else np.eye(3)
    facets = np.array([[0, 1], [1, 2], [2, 0]]) if dimension == 2 else np.array([[0, 1, 2]])
    with RunWriter(tmp_path, provenance={}, obstacles={"wall": (corners, facets), "mast": (corners + 1.0, facets)},
                   dimension=dimension) as writer:
        for i in range(4):
            writer.frame(i * 0.1, np.zeros((3, dimension)), {}, {"wall": pose(i, dimension)},
                         {"wall": loads(i, dimension)})
    run = Run(tmp_path)
    wall, mast = run.obstacles["wall"], run.obstacles["mast"]
    rows = {name: np.concatenate([loads(i, dimension)[name] for i in range(4)]) for name in loads(0)}
    axes = [0, 2] if dimension == 2 else [0, 1, 2]
    assert np.array_equal(wall.force[:, axes], rows["force"]) and np.array_equal(wall.impulse[:, axes], rows["impulse"])
    assert wall.force.shape == (6, 3) and (dimension == 3 or not wall.force[:, 1].any())
    assert all(np.array_equal(getattr(wall, name), rows[name]) for name in ("time", "moment", "work"))
    for i in range(4):
        rotation, translation = pose(i, dimension)
        assert np.allclose(wall.placed(i)[:, axes], corners @ rotation.T + translation, rtol=0.0, atol=1e-14)
        assert np.array_equal(mast.placed(i)[:, axes], corners + 1.0) and not len(mast.time)
    with h5py.File(tmp_path / "run.vtkhdf") as h5:
        units = {name: data.attrs["units"] for name, data in h5["obstacles/wall"].items() if "units" in data.attrs}
    width = "/m" if dimension == 2 else ""
    assert units == {"vertices": "m", "translation": "m", "time": "s", "force": f"N{width}", "moment": f"N m{width}",
                     "impulse": f"N s{width}", "work": f"J{width}"}


def test_a_file_of_before_there_were_obstacles_has_none(run_path):
    with h5py.File(run_path / "run.vtkhdf", "r+") as h5:
        del h5["obstacles"], h5["surroundings"]
    assert Run(run_path).obstacles == {}
    with RunWriter.reopen(run_path, until=0.2, durable=False) as writer:
        writer.frame(0.3, *state(3, N))
    assert len(Run(run_path)) == 4


def test_a_map_may_be_written_again_in_another_size(tmp_path):
    with new_writer(tmp_path) as writer:
        for shape in ((3, 4), (3, 4), (5, 6)):
            writer.map("peak_speed", np.full(shape, shape[0]), 0.0, 0.0, 1.0, "m/s")
            assert Run(tmp_path).maps["peak_speed"].values.shape == shape
    assert (Run(tmp_path).maps["peak_speed"].values == 5).all()


def test_plane_strain_rows_are_stored_as_x_0_z(tmp_path):
    with RunWriter(tmp_path, provenance={}, terrain=([[0.0, 3.0], [1.0, 2.0]], [[0, 1]]), dimension=2) as writer:
        writer.frame(0.0, np.array([[1.0, 2.0]]), {"velocity": np.array([[3.0, 4.0]])})
    run = Run(tmp_path)
    assert run.frame(0).points.tolist() == [[1.0, 0.0, 2.0]]
    assert run.frame(0).fields["velocity"].tolist() == [[3.0, 0.0, 4.0]]
    assert run.terrain.vertices.tolist() == [[0.0, 0.0, 3.0], [1.0, 0.0, 2.0]]
    assert run.terrain.facets.tolist() == [[0, 1]]


def test_vtk_reads_every_step(run_path):
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(run_path / "run.vtkhdf"))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 6
    for i in range(6):
        reader.SetStep(i)
        reader.Update()
        output = reader.GetOutput()
        points, fields = state(i, N)
        assert reader.GetTimeValue() == i * 0.1
        assert output.GetNumberOfVerts() == len(points)
        assert np.array_equal(vtk_to_numpy(output.GetVerts().GetConnectivityArray()), np.arange(len(points)))
        assert np.array_equal(vtk_to_numpy(output.GetPoints().GetData()), points + np.array(ORIGIN))
        for name, values in fields.items():
            assert np.array_equal(vtk_to_numpy(output.GetPointData().GetArray(name)), values), name


def test_vtk_and_plain_hdf5_open_a_run_that_goes_on(tmp_path):
    """No lock, no open-for-write mark: what lies on the disk between two frames is a closed file."""
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    with new_writer(tmp_path) as writer:
        for count in (1, 2, 3):
            write_frame(writer, count - 1, N)
            with h5py.File(tmp_path / "run.vtkhdf", "r", locking=True) as h5:
                assert h5["VTKHDF/Steps"].attrs["NSteps"] == count
            reader = hdf.vtkHDFReader()
            reader.SetFileName(str(tmp_path / "run.vtkhdf"))
            reader.SetStep(count - 1)
            reader.Update()
            assert reader.GetNumberOfSteps() == count
            assert reader.GetOutput().GetNumberOfPoints() == n_points(count - 1, N)


def test_vtk_reads_a_step_without_particles(tmp_path):
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    with new_writer(tmp_path, units={}) as writer:
        for n in (3, 0, 2):
            writer.frame(float(n), np.ones((n, 3)), {"density": np.ones(n)})
    assert len(Run(tmp_path).frame(1)) == 0
    reader = hdf.vtkHDFReader()
    reader.SetFileName(str(tmp_path / "run.vtkhdf"))
    counts = []
    for i in range(3):
        reader.SetStep(i)
        reader.Update()
        counts.append(reader.GetOutput().GetNumberOfPoints())
    assert counts == [3, 0, 2]


def test_a_step_costs_little_more_than_its_compressed_values(tmp_path):
    """Noise does not compress, so a step weighs about its bytes; 2 % is the index, the alignment and the history."""
    n = 20000
    rng = np.random.default_rng(0)
    with new_writer(tmp_path) as writer:
        sizes = []
        for i in range(12):
            noise = rng.integers(0, 2**31, (n, 3), dtype=np.int32)
            writer.frame(float(i), np.zeros((n, 3)), {"noise": noise})
            sizes.append((tmp_path / "run.vtkhdf").stat().st_size)
    assert np.diff(sizes)[1:].max() < 1.02 * 12 * n


def test_rows_after_the_last_frame_that_stays_go_too(run_path):
    """A checkpoint between two frames has the loads since the first of them: they are written again with the next."""
    with RunWriter.reopen(run_path, until=0.26, durable=False):
        pass
    run = Run(run_path)
    assert run.times[-1] == pytest.approx(0.2)
    assert run.obstacles["wall"].time[-1] == pytest.approx(0.2)  # not 0.25, of the frame at 0.3


def test_reopened_run_continues_after_the_given_time(run_path):
    with RunWriter.reopen(run_path, until=0.3, durable=False) as writer:
        assert not Run(run_path).complete
        assert len(Run(run_path)) == len(Run(run_path).history["time"]) == 4
        for i in (4, 5, 6):
            write_frame(writer, i, N)
    run = Run(run_path)
    assert len(run) == 7 and run.complete
    assert run.history["front"].tolist() == [0, 1, 2, 3, 4, 5, 6]
    assert_whole(run, N)


def test_a_second_writer_is_refused(tmp_path):
    with new_writer(tmp_path) as writer:
        write_frame(writer, 0, N)
        with pytest.raises(InputError, match="another program is writing"):
            new_writer(tmp_path)
        write_frame(writer, 1, N)
    assert_whole(Run(tmp_path), N)


def test_wrong_shapes_are_refused_and_change_nothing(tmp_path):
    with new_writer(tmp_path) as writer:
        write_frame(writer, 0, N)
        points, fields = state(1, N)
        with pytest.raises(ValueError, match="field density"):
            writer.frame(0.1, points, {**fields, "density": np.ones(3)})
        with pytest.raises(ValueError, match="as in the first frame"):
            writer.frame(0.1, points, {"velocity": points})
        write_frame(writer, 1, N)
    assert len(Run(tmp_path)) == 2
    assert_whole(Run(tmp_path), N)


def make_nothing(path):
    """No file at all."""


def make_text(path):
    path.write_text("not HDF5")


def make_foreign(path):
    with h5py.File(path, "w") as h5:
        h5.create_group("VTKHDF")


def make_newer(path):
    new_writer(path).close()
    with h5py.File(path, "r+") as h5:
        h5.attrs["format_version"] = layout.FORMAT_VERSION + 1


@pytest.mark.parametrize(
    ("make", "message"),
    [(make_nothing, "no run file"), (make_text, "not a readable"), (make_foreign, "not a"), (make_newer, "version")],
)
def test_what_is_no_run_file_is_refused_with_its_path(tmp_path, make, message):
    path = tmp_path / "run.vtkhdf"
    make(path)
    with pytest.raises(InputError, match=message) as caught:
        Run(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_unknown_field_names_the_known_ones(run_path):
    with pytest.raises(InputError, match="velocity"):
        Run(run_path).frame(0, ["speed"])


def test_frames_between_which_a_saw_test_has_no_row(tmp_path):
    """Frames may come faster than its rows."""
    x = np.arange(4.0)
    kept = {"about": {}, "series": {"time": "s"}, "lines": {"settlement": "m"}, "bins": {"x": (x, "m")}}
    with RunWriter(tmp_path, provenance={}, dimension=2, saw_test=kept) as writer:
        for i, k in enumerate((1, 0, 2)):
            rows = {"time": np.array([0.1 * i] * k), "settlement": np.array([x] * k)}
            writer.frame(0.1 * i, np.zeros((3, 2)), {}, saw_test=(rows, {"x": x + i}))
    found = Run(tmp_path).saw_test
    assert found["time"].tolist() == [0.0, 0.2, 0.2] and found["settlement"].tolist() == [x.tolist()] * 3
    assert found["x"].tolist() == (x + 2).tolist()


def test_frames_that_wait_are_written_together(tmp_path, monkeypatch):
    """None is on the disk before; then all are, as if each had been written at once."""
    with new_writer(tmp_path / "each") as writer:
        for i in range(6):
            write_frame(writer, i, N)
    with new_writer(tmp_path / "together", patience=100.0) as writer:
        for i in range(4):
            write_frame(writer, i, N)
        assert len(Run(tmp_path / "together")) == 0
        writer.flush()
        assert len(Run(tmp_path / "together")) == 4
        write_frame(writer, 4, N)
        monkeypatch.setattr("snowmpm.io.writer.WAITING_BYTES", 1.0)
        write_frame(writer, 5, N)  # too large to wait
        assert len(Run(tmp_path / "together")) == 6
    for folder in ("each", "together"):
        assert_whole(Run(tmp_path / folder), N)
    with h5py.File(tmp_path / "each" / "run.vtkhdf") as each, h5py.File(tmp_path / "together" / "run.vtkhdf") as both:
        names = []
        each.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        for name in names:
            if name != "provenance/record":
                assert np.array_equal(each[name][()], both[name][()], equal_nan=each[name].dtype.kind == "f"), name

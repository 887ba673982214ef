"""A run from Python: opened without the compiler, as tables and data sets with units, short at a prompt."""

import subprocess
import sys

import numpy as np
import pytest
from run_states import ORIGIN, n_points, new_writer, state, write_frame

import snowmpm
from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter

N = 60
HAZARD = {"numbers": {"runout": 120.0, "area_above_3_kPa": 40.0, "travel_angle": 31.0, "flow_depth": 0.1},
          "profile": {"x": [1.0, 2.0], "y": [1.0, 1.0], "z": [5.0, 4.0], "s": [0.0, 1.0], "peak_depth": [0.5, 0.25],
                      "peak_speed": [3.0, 2.0], "peak_pressure": [1e3, 5e2], "deposit_depth": [0.0, 0.1]}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("run")
    with new_writer(path) as writer:
        for i in range(3):
            write_frame(writer, i, N)
        writer.map("peak_depth", [[0.0, 1.0, 2.0], [3.0, 4.0, np.nan]], x0=10.0, y0=20.0, cell=2.0, units="m")
        writer.hazard(HAZARD)
        writer.provenance({"crs": "a projection", "version": "0.1.0"})
    (path / "summary.json").write_text('{"steps": 7, "last": {"mass": 2.0}}')
    return path


@pytest.fixture
def run(folder):
    return snowmpm.open_run(folder)


def test_a_run_is_opened_by_its_folder_or_its_file(folder):
    for path in (folder, str(folder), folder / "run.vtkhdf"):
        run = snowmpm.open_run(path)
        assert isinstance(run, Run) and len(run) == 3 and len(list(run)) == 3


@pytest.mark.parametrize("what", ["nothing", "text", "folder"])
def test_what_is_no_run_is_refused(tmp_path, what):
    path = tmp_path / "run.vtkhdf"
    if what == "text":
        path.write_text("not a run")
    if what == "folder":
        path = tmp_path
    with pytest.raises(InputError, match=r"no run file here|not a readable run file"):
        snowmpm.open_run(path)


def test_a_run_that_goes_on_is_read_and_looked_at_again(tmp_path):
    pytest.importorskip("xarray")
    writer = new_writer(tmp_path)
    write_frame(writer, 0, N)
    run = snowmpm.open_run(tmp_path)
    write_frame(writer, 1, N)
    assert len(run) == 1 and "not complete" in repr(run)
    run.refresh()
    assert len(run) == 2 and run.to_xarray("particles").sizes["time"] == 2
    writer.close()


def test_opening_a_run_loads_no_compiler_and_little_else(folder):
    """Under a second of processor time, most of it NumPy and h5py."""
    code = ("import sys, time; import snowmpm; run = snowmpm.open_run(sys.argv[1]); run.frame(0); repr(run);"
            "heavy = {'taichi', 'pandas', 'xarray', 'scipy', 'matplotlib', 'vtkmodules', 'trimesh', 'pydantic'};"
            "print(sorted(heavy & set(sys.modules)), time.process_time())")
    done = subprocess.run([sys.executable, "-c", code, folder], capture_output=True, text=True, timeout=60, check=True)
    loaded, seconds = done.stdout.rsplit(" ", 1)
    assert loaded == "[]" and float(seconds) < 1.5


def test_history_as_a_data_set(run):
    pytest.importorskip("xarray")
    data = run.to_xarray()
    assert data.mass.dims == ("time",) and data.time.attrs == {"long_name": "simulated time", "units": "s"}
    assert data.mass.attrs == {"long_name": "mass in the domain", "units": "kg"}
    assert data.front.sel(time=0.1, method="nearest").item() == 1.0
    assert data.attrs["crs_wkt"] == "a projection" and data.attrs["complete"] == 1


def test_particles_as_a_data_set_in_map_coordinates(run):
    pytest.importorskip("xarray")
    data = run.to_xarray("particles")
    assert data.sizes == {"time": 3, "particle": N, "axis": 3, "component": 6}
    assert data.particles.values.tolist() == [n_points(i, N) for i in range(3)]
    for i in range(3):
        points, fields = state(i, N)
        own = data.isel(time=i, particle=slice(len(points)))
        assert np.allclose(own.position.values, points + np.array(ORIGIN), rtol=0.0, atol=1e-9)
        for name, values in fields.items():
            assert np.array_equal(own[name].values, values), name
        assert np.isnan(data.density.values[i, len(points):]).all()
    assert data.stress.attrs["units"] == "Pa" and data.stress.component.values[3] == "xy"


def test_only_the_frames_that_are_asked_for_are_read(run, monkeypatch):
    pytest.importorskip("xarray")
    read = []
    frame = run.frame
    monkeypatch.setattr(run, "frame", lambda i, fields=None: read.append((i, fields)) or frame(i, fields))
    data = run.to_xarray("particles")
    chosen = data.velocity.isel(time=1, axis=2)
    assert read == []
    chosen.load()
    assert read == [(1, ["velocity"])]
    assert data.density.isel(time=slice(0, 2), particle=[3, 1]).shape == (2, 2)
    assert data.density.isel(time=[2, 0], particle=5).values.tolist() == pytest.approx(
        [state(i, N)[1]["density"][5] for i in (2, 0)])


def test_particles_by_dask(run):
    pytest.importorskip("xarray")
    pytest.importorskip("dask")
    mean = run.to_xarray("particles").chunk({"time": 1}).density.mean("particle").values
    assert mean == pytest.approx([state(i, N)[1]["density"].mean() for i in range(3)], rel=1e-5)


def test_maps_as_a_data_set_in_map_coordinates(run, tmp_path):
    pytest.importorskip("xarray")
    data = run.to_xarray("maps")
    assert data.peak_depth.dims == ("y", "x") and data.peak_depth.attrs["units"] == "m"
    assert data.x.values.tolist() == [500010.0, 500012.0, 500014.0] and data.y.values.tolist() == [200020.0, 200022.0]
    assert data.peak_depth.sel(x=500012.0, y=200022.0).item() == 4.0
    data.to_netcdf  # noqa: B018 - a data set as any other
    with pytest.raises(InputError, match="no maps"):
        new_writer(tmp_path).close()
        snowmpm.open_run(tmp_path).to_xarray("maps")


def test_a_saw_test_as_a_data_set(tmp_path):
    pytest.importorskip("xarray")
    x = np.array([0.5, 1.5])
    kept = {"about": {}, "series": {"time": "s", "tip": "m"}, "lines": {"settlement": "m"},
            "bins": {"x": (x, "m"), "arrival": (x, "s"), "broken_at_rest": (x, "1"), "one_of_later_versions": (x, "m")}}
    with RunWriter(tmp_path, provenance={}, dimension=2, saw_test=kept) as writer:
        rows = {"time": np.array([0.0, 0.1]), "tip": np.array([0.2, 0.3]), "settlement": np.array([x, 2 * x])}
        writer.frame(0.1, np.zeros((3, 2)), {}, saw_test=(rows, {"x": x, "arrival": x}))
    data = snowmpm.open_run(tmp_path).to_xarray("saw_test")  # as many rows as bins
    assert data.settlement.dims == ("time", "x") and data.tip.dims == ("time",) and data.arrival.dims == ("x",)
    assert data.broken_at_rest.dims == data.one_of_later_versions.dims == ("x",)
    assert data.settlement.sel(time=0.1, x=1.5).item() == 3.0 and data.arrival.attrs["units"] == "s"


def test_tables(run):
    pytest.importorskip("pandas")
    history = run.to_pandas()
    assert history.index.name == "time" and history["front"].tolist() == [0.0, 1.0, 2.0]
    assert history.attrs["units"]["mass"] == "kg"
    hazard = run.to_pandas("hazard")
    assert hazard.loc["runout", ["value", "unit"]].tolist() == [120.0, "m"] and hazard.loc["runout", "definition"]
    assert "at rest is not known" in hazard.attrs["not_final"][0]
    assert run.to_pandas("thalweg").loc[1.0, "peak_depth"] == 0.25
    loads = run.to_pandas("loads")
    assert loads.loc["wall"].index.tolist() == run.obstacles["wall"].time.tolist()
    assert loads.loc["wall", "force_z"].tolist() == run.obstacles["wall"].force[:, 2].tolist()
    assert loads.attrs["units"]["impulse_x"] == "N s"
    assert run.to_pandas("summary").loc["last.mass", "value"] == 2.0


@pytest.mark.parametrize("ask", ["to_pandas", "to_xarray"])
def test_what_there_is_not_is_said(run, ask):
    pytest.importorskip("xarray")
    with pytest.raises(InputError, match="histroy"):
        getattr(run, ask)("histroy")
    with pytest.raises(InputError, match="saw test"):
        getattr(run, ask)("saw_test")


@pytest.mark.parametrize("package, ask", [("pandas", "to_pandas"), ("xarray", "to_xarray")])
def test_a_missing_package_is_named_in_one_line(run, monkeypatch, package, ask):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=rf"{package}: pip install 'snowmpm\[xarray\]'") as caught:
        getattr(run, ask)()
    assert "\n" not in str(caught.value)


def test_what_a_prompt_shows_fits_on_a_screen(run):
    from snowmpm.materials import LAWS

    scene = snowmpm.load_scene("slab_release_resolved")
    assert LAWS
    for shown in (run, run.frame(1), run.terrain, run.maps["peak_depth"], run.obstacles["wall"], scene,
                  scene.bodies[0], scene.solver, scene.materials["slab"], scene.terrain):
        text = repr(shown)
        assert len(text.splitlines()) <= 15 and len(text) < 1500 and "array(" not in text
        assert max(map(len, text.splitlines())) <= 400
    for words in ("complete", "3, 0 to 0.2 s", "53 to 60", "velocity [m/s]", "peak_depth", "wall", "terrain, hazard"):
        assert words in repr(run), words
    assert "<table>" in run._repr_html_() and "slab_release_resolved" in scene._repr_html_()
    for words in ("slab_release_resolved (3-D)", "mpm, dx = 0.25 m", "slab (cohesive_cam_clay)", "0 to 12 s"):
        assert words in repr(scene), words


def test_a_scene_of_ten_thousand_corners_is_still_short():
    scene = snowmpm.load_scene("column_collapse_2d")
    long = scene.bodies[0].model_copy(update={"name": "x" * 10_000})
    assert len(repr(long)) < 2000

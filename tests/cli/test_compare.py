"""`snowmpm compare`: table, picture and refusals."""

import pytest
from PIL import Image

import snowmpm
from snowmpm.scenes import load_scene


@pytest.fixture
def two_runs(block, tmp_path):
    for name, dx in (("coarse", 0.1), ("fine", 0.05)):
        snowmpm.run(load_scene(block, {"solver.dx": dx, "output.fields": ["velocity", "density", "stress"]}),
                    tmp_path / name)
    return tmp_path / "coarse", tmp_path / "fine"


def test_two_resolutions(two_runs, call, tmp_path, full_figures):
    done = call("compare", *two_runs, "-o", tmp_path / "both.png", "--line", "z=0.2")
    assert done.code == 0, done.err
    head, *rows = done.out.splitlines()
    assert head.split() == ["coarse", "fine"]
    table = {line[:40].split("  ")[0].strip(): line for line in rows}
    assert table["dx [m]"].split()[-2:] == ["0.1", "0.05"]
    assert table["particles"].split()[-2:] == ["32", "128"]
    assert "%" in table["kinetic energy, at most in a frame"] and "%" in table["profile apart, of its depth"]
    assert "known" not in done.out
    with Image.open(tmp_path / "both.png") as picture:
        assert min(picture.size) > 600


def test_a_scene_with_an_answer(block, call, tmp_path):
    """A block of sand that has not moved yet: run-out and height beside the laws of collapses."""
    sand = {"solver.dx": 0.05, "materials.snow": {"card": "lube_sand", "youngs_modulus": 1e5}, "end_time": 0.004,
            "output.interval": 0.002, "reference": {"kind": "plane_column"}, "bodies.0.velocity": [0.0, 0.0]}
    for name in ("a", "b"):
        snowmpm.run(load_scene(block, sand), tmp_path / name)
    done = call("compare", tmp_path / "a", tmp_path / "b", "-o", tmp_path / "both.pdf")
    assert done.code == 0, done.err
    assert "run-out [m], known 0.64" in done.out and "height of the middle [m], known 0.2" in done.out
    assert "doi:10.1103/PhysRevE.72.041301" in done.out and "alpha = 1.0424" in done.out
    assert (tmp_path / "both.pdf").stat().st_size > 1000


@pytest.mark.parametrize(("arguments", "expected"), [
    (("coarse",), "1 run to compare: name 2 to 12"),
    (("coarse", "none"), "none: no run file here"),
    (("coarse", "fine", "-o", "both.jpeg"), "must end in .png, .pdf or .svg"),
    (("coarse", "fine", "--line", "y=2"), "--line y=2: must be x=METRES (upright) or z=METRES (level)"),
    (("coarse", "fine", "--time", "5"), "--time 5: "),
])
def test_refusals(two_runs, call, arguments, expected):
    done = call("compare", *arguments)
    assert done.code == 2
    assert done.err.startswith("error: ") and expected in done.err
    assert done.err.count("\n") <= 2


@pytest.mark.parametrize(("reference", "expected"), [
    ({"kind": "columns"}, 'reference.kind = "columns": must be one of'),
    ({"kind": "round_column"}, 'reference.kind = "round_column": exists only in a 3-D scene'),
    ({"kind": "oedometer", "piston": "lid"}, 'reference.piston = "lid": must be one of the obstacles: none'),
    ({"kind": "cantilever", "length": 2.0}, "reference.length = 2.0: unknown key"),
])
def test_wrong_references(block, call, reference, expected):
    text = "{" + ", ".join(f"{key}={value!r}" for key, value in reference.items()) + "}"
    done = call("check", block, "--set", f"reference={text}")
    assert done.code == 2 and expected in done.err, done.err


def test_runs_in_two_coordinate_systems_are_compared_but_for_their_places(two_runs, call, tmp_path, monkeypatch):
    """Speeds, energies and cost have no place; profiles and fronts have."""
    import pyproj

    from snowmpm.io import Run

    own = Run.provenance.func if hasattr(Run.provenance, "func") else Run.provenance.fget
    codes = {"coarse": 32632, "fine": 31287}

    def provenance(run):
        return {**own(run), "crs": pyproj.CRS.from_epsg(codes[run.path.parent.name]).to_wkt()}

    monkeypatch.setattr(Run, "provenance", property(provenance))
    done = call("compare", *two_runs, "-o", tmp_path / "both.png")
    assert done.code == 0, done.err
    assert "coordinate systems differ (coarse: " in done.err and "no picture is drawn" in done.err
    assert "fastest particle" in done.out and "profile" not in done.out and "front" not in done.out
    assert not (tmp_path / "both.png").exists()

"""Element tests along paths from files, and files that are refused."""

from itertools import pairwise

import numpy as np
import pytest
from parameter_sets import A, B

from snowmpm.materials import LoadingError, MaterialPoint, measure, measure_path, read_loading


def write(tmp_path, text):
    file = tmp_path / "path.csv"
    file.write_text(text)
    return file


def test_a_file_of_strains_and_stresses(tmp_path):
    # Drained triaxial: load, unload to the isotropic stress, reload
    text = "# made by hand\nstrain_zz [-], stress_zz, stress_xx [Pa], stress_yy [Pa], duration\n"
    text += "-0.05,,-8e3,-8e3,2\n\n,-8e3,-8e3,-8e3,1\n-0.1,,-8e3,-8e3,1\n"
    found = measure_path(A, read_loading(write(tmp_path, text)), pressure=8e3, steps=50)
    table = found.table()
    assert len(found.rows) == 151 and table["time"][1][-1] == pytest.approx(4.0)
    reference = measure(A, "triaxial", pressure=8e3, strain=0.05, steps=50)
    np.testing.assert_allclose(table["q"][1][:51], reference.table()["q"][1], rtol=1e-9, atol=1e-6)
    assert table["q"][1][100] == pytest.approx(0.0, abs=1e-4)
    assert not table["iterations"][1][52:101].any() and table["iterations"][1][-1] > 0
    assert table["strain_zz"][1][150] == -0.1
    assert np.isnan(table["prescribed_stress_zz"][1][[0, 50, 101]]).all()


def test_a_file_of_deformation_gradients(tmp_path):
    text = "F_xx,F_xz,F_zz,duration\n0.98,0,0.99,1\n0.98,0.2,0.97,3\n"
    loading = read_loading(write(tmp_path, text))
    found = measure_path(A, loading, steps=10)
    middle = np.array([np.diag([0.98, 1.0, 0.99]), [[0.98, 0, 0.2], [0, 1.0, 0], [0, 0, 0.97]]])
    ends = np.concatenate([np.eye(3)[None], middle])
    share = np.arange(1, 11)[:, None, None] / 10.0
    F = np.concatenate([a + share * (b - a) for a, b in pairwise(ends)])
    path = MaterialPoint(A).drive(F)
    np.testing.assert_allclose(found.path.kirchhoff[1:], path.kirchhoff, rtol=1e-10, atol=1e-8)
    table = found.table()
    np.testing.assert_allclose(table["F_xz"][1][[10, 15, 20]], [0.0, 0.1, 0.2], atol=1e-15)
    assert table["time"][1][-1] == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("strain_zz\n-0.1\nmuch\n", "line 3, column strain_zz = much: must be a finite number"),
        ("strain_zz\n-0.1\nnan\n", "line 3, column strain_zz = nan"),
        ("strain_zz,stress_xx\n-0.1\n", "line 2: 1 values for 2 columns"),
        ("strain_zz,stress_xx\n-0.1,\n", "line 2, column stress_xx is empty"),
        ("strain_zz,stress_zz\n-0.1,-1e3\n", "line 2, column stress_zz and its strain: exactly one"),
        ("strain_zz,stress_zz\n,\n", "line 2, column stress_zz and its strain: exactly one"),
        ("strain_zy\n0.1\n", "column 'strain_zy' is not known; did you mean strain_"),
        ("temperature\n0.1\n", "column 'temperature' is not known"),
        ("stress_xx [kPa]\n0.1\n", r"column stress_xx: the unit must be \[Pa\], not \[kPa\]"),
        ("strain_zz,strain_zz\n0.1,0.1\n", "column strain_zz comes twice"),
        ("F_xx,strain_zz\n1,0\n", "columns F_"),
        ("duration\n1\n", "no column says what to do"),
        ("strain_zz,duration\n0.1,0\n", "line 2, column duration = 0: must be a number > 0"),
        ("strain_zz,duration\n0.1,\n", "line 2, column duration: empty"),
        ("F_xx,F_zz\n1,1\n-1,1\n", "line 3: det F = -1: must be > 0"),
        ("strain_zz\n", "needs a line of column names and at least one row"),
        ("", "needs a line of column names and at least one row"),
    ],
)
def test_bad_files_are_refused(tmp_path, text, message):
    file = write(tmp_path, text)
    with pytest.raises(LoadingError, match=message) as error:
        read_loading(file)
    assert str(error.value).startswith(str(file))


def test_files_that_are_no_text_are_refused(tmp_path):
    file = tmp_path / "path.csv"
    file.write_bytes(b"\xff\xfe\x00strain_zz")
    with pytest.raises(LoadingError, match="not a text file"):
        read_loading(file)
    with pytest.raises(OSError):
        read_loading(tmp_path / "none.csv")


def test_a_turn_by_half_a_circle_needs_rows_between(tmp_path):
    loading = read_loading(write(tmp_path, "F_xx,F_zz\n1,1\n-1,-1\n"))
    with pytest.raises(LoadingError, match="det F <= 0 on the way to row 2"):
        measure_path(A, loading, steps=2)


def test_a_stress_out_of_reach_names_the_step(tmp_path):
    # Critical state: σ1 = σ3 + M 3 σ3 / (3 − M) = 4800 Pa, three steps of 600 Pa into the second row, met in the limit
    loading = read_loading(write(tmp_path, "stress_zz,stress_xx,stress_yy\n-3e3,-3e3,-3e3\n-9e3,-3e3,-3e3\n"))
    with pytest.raises(LoadingError, match="step 13: stress xx = -3000 Pa"):
        measure_path(B, loading, steps=10)

"""Tables of text that name motion and loading, and tables of studies: refused with their line, never a fault."""

import pytest
from scenes_under_attack import block, written

from snowmpm.errors import InputError
from snowmpm.measured import borders
from snowmpm.study import measurement, stability

OBSTACLE = '''
[[obstacles]]
name = "plate"
shape = { kind = "box", min = [0.0, 0.6], max = [0.4, 0.7] }
motion = { file = "motion.csv" }
'''
LOTS = "9" * 5000
MOTIONS = {
    "empty": "", "header": "time,x\n", "one_row": "time,x\n0,0\n", "nul": "time,x\n0,\0\n1,1\n",
    "long_field": "time,x\n0," + "1" * 200_000 + "\n1,1\n", "long_name": "t" * 200_000 + ",x\n0,0\n1,1\n",
    "quoted": 'time,x\n0,"' + "a" * 200_000 + "\n1,1\n", "open_quote": 'time,x\n0,"1\n1,1\n',
    "digits": f"time,x\n0,0\n{LOTS},1\n", "nan": "time,x\n0,nan\n1,1\n", "inf": "time,x\n0,0\ninf,1\n",
    "back": "time,x\n1,0\n0,1\n", "same": "time,x\n0,0\n0,1\n", "twice": "time,time\n0,0\n1,1\n",
    "unknown": "time,\x1b[2J\n0,0\n1,1\n", "no_time": "x,z\n0,0\n1,1\n", "wide": "time" + ",x" * 4000 + "\n0\n1\n",
    "ragged": "time,x\n0\n1,1,1\n", "binary": b"\xff\xfe\x00\x01" * 500, "utf16": "time,x\n0,0\n1,1\n".encode("utf-16"),
    "formula": "time,x\n0,=1+1\n1,1\n", "underscore": "time,x\n0,1__0\n1,1\n",
    "large": "time,x\n" + "0,0\n" * 2_000_000,
}


@pytest.mark.parametrize("name", MOTIONS)
def test_motion(withstood, tmp_path, name):
    written(tmp_path / "motion.csv", MOTIONS[name])
    block(tmp_path, more=OBSTACLE)
    withstood("check", "scene.toml", code=(0, 2) if name == "open_quote" else 2)


@pytest.mark.parametrize("rows", ["0,0\n1,1e300\n", "0,0\n1e-300,1\n", "-1e300,0\n1e300,1\n", "0,1e12\n1,-1e12\n"])
def test_motion_without_measure(withstood, tmp_path, rows):
    written(tmp_path / "motion.csv", "time,x\n" + rows)
    block(tmp_path, more=OBSTACLE)
    withstood("check", "scene.toml")


PATHS = {
    "empty": "", "header": "strain_zz\n", "nul": "strain_zz\n\0\n", "long_field": "strain_zz\n" + "1" * 200_000 + "\n",
    "long_name": "s" * 200_000 + "\n1\n", "spaces": "strain_zz" + " " * 100_000 + "x\n1\n",
    "quoted": 'strain_zz\n"' + "a" * 200_000 + "\n", "digits": f"strain_zz\n{LOTS}\n", "nan": "strain_zz\nnan\n",
    "twice": "strain_zz,strain_zz\n1,1\n", "unknown": "\x1b[2J\n1\n", "unit": "strain_zz [\x1b[31m]\n1\n",
    "both": "strain_zz,F_xx\n1,1\n", "binary": b"\xff\xfe\x00\x01" * 500, "ragged": "strain_zz,strain_xx\n1\n",
    "folded": "F_xx\n-1\n", "no_time": "strain_zz,duration\n1,0\n", "backwards": "strain_zz,duration\n1,-1\n",
    "large": "strain_zz\n" + "0.1\n" * 2_000_000, "sparse": None,
}


@pytest.mark.parametrize("name", PATHS)
def test_loading_path(withstood, tmp_path, name):
    path = written(tmp_path / "path.csv", PATHS[name] or "")
    if PATHS[name] is None:
        with open(path, "r+b") as file:
            file.truncate(1 << 40)
    withstood("element", "path.csv", "-m", "li_cold_dense", code=2)


@pytest.mark.parametrize("path", ["/dev/zero.csv", "/dev/null/x.csv", "none.csv", ".csv", "x" * 300 + ".csv"])
def test_loading_path_that_is_no_file(withstood, path):
    withstood("element", path, "-m", "li_cold_dense", code=2)


def test_too_many_steps_of_a_path(withstood, tmp_path):
    written(tmp_path / "path.csv", "strain_zz\n" + "0.1\n" * 1000)
    withstood("element", "path.csv", "-m", "li_cold_dense", "--steps", "999999", code=2)


@pytest.mark.slow
@pytest.mark.parametrize("row", ["1e300", "-1e300", "700", "1e-320"])
def test_loading_without_measure(withstood, tmp_path, row):
    """A strain that cannot be represented: the test fails with a reason or is made."""
    written(tmp_path / "path.csv", f"strain_zz\n{row}\n")
    withstood("element", "path.csv", "-m", "li_cold_dense", "-o", "out", code=(0, 2))


TABLES = {"empty_row": "a\n1\n", "binary": b"\xff" * 50, "long": "a\n" + "1" * 200_000 + "\n", "nul": "a\n\0\n",
          "words": "entry,setting,value,symptom,cells,seconds,error,lowest,highest,held\nx,y,z,w,a,b,c,d,e,f\n"}


@pytest.mark.parametrize("name", TABLES)
def test_tables_of_studies(tmp_path, name):
    for file, read in (("accuracy_speed.csv", measurement.read), ("stability_borders.csv", borders.read)):
        written(tmp_path / file, TABLES[name])
        with pytest.raises(InputError, match=file):
            read(tmp_path / file)
    written(tmp_path / stability.BORDERS, borders.SHIPPED.read_bytes())
    written(tmp_path / stability.TABLE, TABLES[name])
    with pytest.raises(InputError, match=stability.TABLE):
        stability._kept(tmp_path)

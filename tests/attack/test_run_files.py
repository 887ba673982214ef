"""Run files that were laid out to do harm: refused in bounded time and memory, whatever is asked of them."""

import os
import subprocess
import sys
import time
import zlib

import h5py
import numpy as np
import pytest
from scenes_under_attack import copied

from snowmpm.io.journal import PATCH
from tests.support.good_run import good_run, journal

COMMANDS = [("info",), ("plot",)]
BILLIONS = 1 << 33


@pytest.fixture(scope="session")
def good(tmp_path_factory):
    return good_run(tmp_path_factory.mktemp("good") / "run")


@pytest.fixture
def run(good, tmp_path):
    """A copy of the good run."""
    return copied(tmp_path, good)


def changed(run, change):
    with h5py.File(run / "run.vtkhdf", "r+") as h5:
        change(h5)


def test_the_good_run_is_accepted(withstood, run):
    for command in [*COMMANDS, ("maps", "--files", "pictures")]:
        withstood(command[0], "run", *command[1:], code=0)


def bomb(h5, where, name, shape, **options):
    """A table of zeros that were never written, or written compressed."""
    if name in h5[where]:
        del h5[where][name]
    h5[where].create_dataset(name, shape, "f8", chunks=True, compression="gzip", **options)


def written_bomb(h5):
    data = h5["history"].create_dataset("stolen", (1 << 27,), "f8", chunks=(1 << 22,), compression="gzip")
    data[: 1 << 23] = 0.0


def many(make):
    def change(h5):
        for i in range(21_000):
            make(h5, i)
    return change


def chain(h5):
    group = h5["history"]
    for _ in range(3000):
        group = group.create_group("a")


def set_record(where, value):
    def change(h5):
        if where in h5:
            del h5[where]
        h5[where] = value
    return change


def replaced(where, **options):
    def change(h5):
        attributes = dict(h5[where].attrs) if where in h5 else {}
        if where in h5:
            del h5[where]
        h5.create_dataset(where, **options).attrs.update(attributes)
    return change


def attribute(where, name, value):
    def change(h5):
        h5[where].attrs[name] = value
    return change


def gone(where):
    def change(h5):
        del h5[where]
    return change


text = h5py.string_dtype()
STRUCTURES = {
    "holds_itself": lambda h5: h5["history"].__setitem__("again", h5["history"]),
    "holds_the_root": lambda h5: h5["history"].__setitem__("root", h5["/"]),
    "holds_above": lambda h5: h5["VTKHDF/Steps"].__setitem__("above", h5["VTKHDF"]),
    "two_hold_each_other": lambda h5: (h5["maps"].__setitem__("a", h5["history"]),
                                       h5["history"].__setitem__("b", h5["maps"])),
    "same_table_twice": lambda h5: h5["history"].__setitem__("twin", h5["history/mass"]),
    "soft_cycle": lambda h5: h5["history"].__setitem__("again", h5py.SoftLink("/history")),
    "soft_to_itself": lambda h5: h5["history"].__setitem__("again", h5py.SoftLink("/history/again")),
    "dangling": lambda h5: h5["history"].__setitem__("again", h5py.SoftLink("/nowhere")),
    "external_link": lambda h5: h5["history"].__setitem__("again", h5py.ExternalLink("/etc/passwd", "/")),
    "external_cycle": lambda h5: h5["history"].__setitem__("again", h5py.ExternalLink("run.vtkhdf", "/history")),
    "external_data": lambda h5: h5["history"].create_dataset("x", (4,), "f8", external=[("/etc/passwd", 0, 32)]),
    "external_device": lambda h5: h5["history"].create_dataset("x", (4,), "f8", external=[("/dev/zero", 0, 32)]),
    "virtual": lambda h5: h5["history"].create_virtual_dataset("x", _virtual()),
    "chain_of_groups": chain,
    "many_groups": many(lambda h5, i: h5.create_group(f"x/{i}")),
    "declared_history": lambda h5: bomb(h5, "history", "x", (BILLIONS,)),
    "declared_time": lambda h5: bomb(h5, "history", "time", (BILLIONS,)),
    "declared_map": lambda h5: bomb(h5, "maps", "x", (1 << 17, 1 << 16)),
    "declared_terrain": lambda h5: bomb(h5, "terrain", "vertices", (BILLIONS, 3)),
    "declared_obstacle": lambda h5: bomb(h5, "obstacles/wall", "rotation", (BILLIONS, 3, 3)),
    "declared_points": lambda h5: bomb(h5, "VTKHDF", "Points", (BILLIONS, 3)),
    "declared_saw_test": lambda h5: (h5.create_group("saw_test"), bomb(h5, "saw_test", "time", (BILLIONS,))),
    "declared_chunk": replaced("history/front", shape=(3,), dtype="f8", maxshape=(None,), chunks=(1 << 28,),
                               compression="gzip"),
    "compressed": written_bomb,
    "many_small_bombs": lambda h5: [bomb(h5, "history", f"x{i}", (1 << 22,)) for i in range(100)],
    "declared_text": replaced("provenance/record", shape=(BILLIONS,), dtype=text, chunks=True),
    "fixed_text": replaced("provenance/record", shape=(), dtype="S1000000000"),
    "steps_beyond": attribute("VTKHDF/Steps", "NSteps", 1 << 60),
    "steps_below": attribute("VTKHDF/Steps", "NSteps", -5),
    "steps_text": attribute("VTKHDF/Steps", "NSteps", "many"),
    "counts_beyond": lambda h5: h5["VTKHDF/NumberOfPoints"].__setitem__(1, 1 << 62),
    "counts_below": lambda h5: h5["VTKHDF/NumberOfPoints"].__setitem__(1, -3),
    "offsets_below": lambda h5: h5["VTKHDF/Steps/PointOffsets"].__setitem__(1, -(1 << 62)),
    "times_nan": lambda h5: h5["VTKHDF/Steps/Values"].__setitem__(1, np.nan),
    "points_flat": replaced("VTKHDF/Points", data=np.zeros(1000)),
    "points_wide": replaced("VTKHDF/Points", data=np.zeros((1000, 1000))),
    "points_text": replaced("VTKHDF/Points", data=[b"a"] * 1000),
    "field_cube": replaced("VTKHDF/PointData/density", data=np.zeros((1000, 3, 3))),
    "field_short": replaced("VTKHDF/PointData/density", data=np.zeros(3)),
    "field_group": lambda h5: h5["VTKHDF/PointData"].create_group("g"),
    "field_dtype": lambda h5: h5["VTKHDF/PointData"].__setitem__("t", np.dtype("f8")),
    "history_scalar": replaced("history/mass", data=1.0),
    "history_text": replaced("history/mass", data=[b"a", b"b", b"c"]),
    "history_table": replaced("history/mass", data=np.zeros((3, 3))),
    "history_short": replaced("history/mass", data=np.zeros(1)),
    "history_compound": replaced("history/mass", data=np.zeros(3, [("a", "f8"), ("b", "i4")])),
    "history_references": replaced("history/mass", shape=(3,), dtype=h5py.ref_dtype),
    "history_rows": replaced("history/mass", shape=(3,), dtype=h5py.vlen_dtype(np.float64)),
    "history_group": lambda h5: h5["history"].create_group("g"),
    "no_history": gone("history"), "no_points": gone("VTKHDF/Points"), "no_maps": gone("maps"),
    "no_record": gone("provenance/record"), "no_steps": gone("VTKHDF/Steps"), "no_time": gone("history/time"),
    "facets_beyond": lambda h5: h5["terrain/facets"].__setitem__((0, 0), 1 << 30),
    "facets_below": lambda h5: h5["terrain/facets"].__setitem__((0, 0), -7),
    "facets_wide": replaced("terrain/facets", data=np.zeros((4, 9), int)),
    "vertices_flat": replaced("terrain/vertices", data=np.zeros(9)),
    "obstacle_of_nothing": gone("obstacles/wall/force"),
    "obstacle_with_more": lambda h5: h5["obstacles/wall"].__setitem__("more", 1.0),
    "obstacle_moves_wrong": replaced("obstacles/wall/rotation", data=np.zeros((3, 2, 2))),
    "origin_nan": attribute("/", "origin", [np.nan] * 3), "origin_long": attribute("/", "origin", [0.0] * 100),
    "origin_text": attribute("/", "origin", "x"), "dimension_7": attribute("/", "dimension", 7),
    "dimension_text": attribute("/", "dimension", "x"), "version_text": attribute("/", "format_version", "x"),
    "format_list": attribute("/", "format", ["snowmpm"] * 3), "complete_text": attribute("/", "complete", ["x", "y"]),
    "units_number": attribute("history/mass", "units", 5),
    "units_long": attribute("history/mass", "units", "m" * 50_000),
    "map_cell_0": attribute("maps/peak_depth", "cell", 0.0),
    "map_cell_nan": attribute("maps/peak_depth", "cell", np.nan),
    "map_line": replaced("maps/peak_depth", data=np.zeros(3)), "map_empty": replaced("maps/peak_depth",
                                                                                     data=np.zeros((0, 5))),
    "map_named_above": lambda h5: h5["maps"].__setitem__("...", np.zeros((2, 2))),
    "name_escape": lambda h5: h5["history"].__setitem__("\x1b[2J", np.zeros(3)),
    "name_long": lambda h5: h5["history"].__setitem__("x" * 60_000, np.zeros(3)),
    "name_newline": lambda h5: h5["history"].__setitem__("a\nb", np.zeros(3)),
}


def _virtual():
    layout = h5py.VirtualLayout((4,), "f8")
    layout[:] = h5py.VirtualSource("/etc/passwd", "x", shape=(4,))
    return layout


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow) if name == "many_groups" else name
                                  for name in STRUCTURES])
def test_structure(withstood, run, name):
    changed(run, STRUCTURES[name])
    accepted = ("units_number", "units_long", "complete_text", "same_table_twice")  # of no harm
    for command in COMMANDS[:1] if name not in accepted else COMMANDS:
        withstood(command[0], "run", *command[1:], code=(0, 2) if name in accepted else 2)


NESTED = "[" * 100_000
RECORDS = {
    "list": "[]", "number": "1", "null": "null", "empty": "", "nested": NESTED, "digits": '{"dx": ' + "9" * 5000 + "}",
    "not_json": "{", "bom": "\ufeff{}", "dx_text": '{"dx": "a"}', "dx_huge": '{"dx": 1' + "0" * 400 + "}",
    "scene_list": '{"scene": [1]}', "name_number": '{"scene_name": 5}', "materials_text": '{"materials": "abc"}',
    "materials_tables": '{"materials": [{}]}', "bodies_number": '{"bodies": 1}', "crs_list": '{"crs": [1]}',
    "many_lists": '{"a": [' + "[]," * 2_000_000 + "[]]}",
}


@pytest.mark.parametrize("name", RECORDS)
def test_provenance(withstood, run, name):
    changed(run, set_record("provenance/record", RECORDS[name]))
    withstood("info", "run", code=(0, 2) if name in ("bom", "many_lists") else 2)


@pytest.mark.parametrize("record", ["{}", '{"dx": null}', '{"scene": "[[[["}', '{"scene": "x = 1"}',
                                    '{"attribution": {"attribution": [{"attribution": 1}]}}',
                                    '{"scene": "' + "a." * 30_000 + 'b = 1"}'], ids=lambda text: text[:20])
@pytest.mark.parametrize("command", [("info",), pytest.param(("report", "--still"), marks=pytest.mark.slow),
                                     pytest.param(("render", "-o", "page.html"), marks=pytest.mark.slow),
                                     ("plot", "--compression"),
                                     ("render", "-o", "p.png", "--color", "fracture", "--time", "0")],
                         ids=lambda command: " ".join(command[:2]))
def test_provenance_of_less(withstood, run, record, command):
    changed(run, set_record("provenance/record", record))
    withstood(command[0], "run", *command[1:])


@pytest.mark.parametrize("record", [
    "[]", NESTED, '{"numbers": []}', '{"numbers": {"runout": "far"}}', '{"profile": {"x": 1}}',
    '{"profile": {"x": [1], "y": []}}', '{"profile": {"x": ["a"]}}', '{"runout_line": [[1]]}', '{"runout_line": 5}',
    '{"runout_line": [[1, 2], [3, "x"]]}', '{"numbers": {"runout": 1' + "0" * 400 + "}}",
], ids=lambda text: text[:24])
def test_hazard(withstood, run, record):
    changed(run, set_record("hazard/record", record))
    withstood("maps", "run", "--files", "pictures", code=2)


@pytest.mark.parametrize("record", [
    "{}", '{"numbers": {}}', '{"numbers": {"unknown": 1}}', '{"runout_line": [[0, 0], [1, 1]]}',
    '{"profile": {"x": [0, 1], "y": [0, 1]}}', '{"numbers": {"runout": NaN}}', '{"profile": {}}',
], ids=lambda text: text[:24])
@pytest.mark.parametrize("command", [("info",), ("maps", "--files", "pictures"),
                                     pytest.param(("report", "--still"), marks=pytest.mark.slow)],
                         ids=lambda command: command[0])
def test_hazard_of_less(withstood, run, record, command):
    changed(run, set_record("hazard/record", record))
    withstood(command[0], "run", *command[1:])


SUMMARIES = {
    "list": "[]", "text": '"x"', "empty": "", "nested": NESTED, "digits": '{"steps": ' + "9" * 5000 + "}",
    "wall_text": '{"wall_time": "long"}', "wall_list": '{"wall_time": []}', "steps_text": '{"steps": "many"}',
    "last_list": '{"last": [1]}', "causes": '{"dt_causes": {"a": "b"}}', "of": '{"wall_time_of": [1]}',
    "latin": b'{"a": "\xe9"}', "nul": b"\0" * 100, "dt": '{"smallest_dt": "x"}',
}


@pytest.mark.parametrize("name", SUMMARIES)
def test_summary(withstood, run, name):
    content = SUMMARIES[name]
    (run / "summary.json").write_bytes(content if isinstance(content, bytes) else content.encode())
    withstood("info", "run", code=2)


def test_summary_without_an_end(withstood, run):
    (run / "summary.json").unlink()
    os.truncate(os.open(run / "summary.json", os.O_CREAT | os.O_WRONLY), 1 << 40)
    withstood("info", "run", code=2)
    (run / "summary.json").unlink()
    os.mkfifo(run / "summary.json")
    withstood("info", "run", code=0)


@pytest.mark.parametrize("content", [
    b"", b"\0" * 100, journal(b"abc"), journal(b"", length=1 << 62), journal(PATCH.pack(1 << 62, 3) + b"abc"),
    journal(PATCH.pack(0, 1 << 62)), journal(PATCH.pack(0, 8) + b"\0" * 8), journal(PATCH.pack(0, 0) * 5_000),
    journal(PATCH.pack(0, 100_000) + b"\xff" * 100_000),
], ids=lambda content: f"{len(content)}_{zlib.crc32(content)}")
def test_journal(withstood, run, content):
    (run / "run.vtkhdf.journal").write_bytes(content)
    withstood("info", "run")


def test_journal_without_an_end(withstood, run):
    os.mkfifo(run / "run.vtkhdf.journal")
    withstood("info", "run", code=0)
    (run / "run.vtkhdf.journal").unlink()
    os.truncate(os.open(run / "run.vtkhdf.journal", os.O_CREAT | os.O_WRONLY), 1 << 40)
    withstood("info", "run", code=2)


@pytest.mark.parametrize("content", [b"", b"\x89HDF\r\n\x1a\n", b"\x89HDF\r\n\x1a\n" + b"\xff" * 2000, b"\0" * 5000])
def test_bytes_that_are_no_run_file(withstood, run, content):
    (run / "run.vtkhdf").write_bytes(content)
    withstood("info", "run", code=2)


PICTURE = ("render", "--time", "0.1", "--size", "96x64", "-o", "p.png")
DRAWN_BY = {"VTKHDF/Points": PICTURE, "VTKHDF/PointData/velocity": PICTURE, "history/front": ("plot",),
            "history/time": ("plot",), "history/max_speed": ("plot",), "terrain/vertices": PICTURE,
            "maps/peak_depth": ("maps", "--files", "pictures"), "obstacles/wall/impulse": ("info",),
            "obstacles/wall/time": ("info",), "obstacles/wall/rotation": PICTURE}


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e38, 0.0])
@pytest.mark.parametrize("where", DRAWN_BY)
def test_numbers(withstood, run, where, value):
    """Everything in one table is the same extreme number: what cannot be drawn is refused, not a fault."""
    changed(run, lambda h5: h5[where].__setitem__(..., value))
    command, *options = DRAWN_BY[where]
    withstood(command, "run", *options)


@pytest.mark.slow
@pytest.mark.parametrize("value", [np.nan, np.inf, 1e38, 0.0])
@pytest.mark.parametrize("where", DRAWN_BY)
def test_numbers_in_a_report(withstood, run, where, value):
    changed(run, lambda h5: h5[where].__setitem__(..., value))
    withstood("report", "run", "-o", "report.html")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="of systems with signals")
def test_a_terminated_command_ends(run):
    """A writer that never lets a reader finish: three requests to end suffice, whatever forgets the first two."""
    script = ("import snowmpm.running.interruption as i, time\n"
              "with i.requests_to_end():\n"
              "    told = 'begun'\n"
              "    while True:\n"
              "        try:\n            print(told, flush=True)\n            time.sleep(60)\n"
              "        except KeyboardInterrupt:\n            told = 'forgot'\n")
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    try:
        for said in ("begun", "forgot", "forgot"):
            assert process.stdout.readline().strip() == said
            process.terminate()
        deadline = time.monotonic() + 30.0
        while process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        assert process.returncode == -15
    finally:
        process.kill()
        process.wait()

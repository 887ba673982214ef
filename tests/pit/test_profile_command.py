"""`snowmpm profile`: what it prints and writes, of one profile and of a folder; what it refuses."""

import csv
import json
import os

import pytest

from snowmpm.errors import InputError
from snowmpm.pit import batch
from tests.support.project import ROOT
from tests.support.snow_pits import CSV, PRO, caaml, write


@pytest.fixture
def pits(tmp_path, monkeypatch):
    """A folder of six profiles, of which two cannot tell; few columns for their intervals, as they take most of the
    time."""
    monkeypatch.setattr(batch, "SAMPLES", 16)
    folder = tmp_path / "pits"
    (folder / "winter").mkdir(parents=True)
    for name in ("pit.xml", "pit.pro", "pit.csv"):
        write(folder, name)
    write(folder / "winter", "steep.xml", caaml(angle="42"))
    write(folder / "winter", "broken.xml", caaml()[:700])
    write(folder / "winter", "unknown.xml", caaml([(0, 20, "", 1.0, "", None), (20, 25, "DH", 1.0, "F", None)],
                                                  tests=()))
    return folder


def test_one_profile(cli, tmp_path):
    path = write(tmp_path)
    done = cli("profile", str(path), "-o", str(tmp_path / "out"))
    assert done.exit_code == 0, done.output
    for words in ("Made-up slope (CAAML): 2026-01-28 13:00, 2100 m, N, 36 degrees", ">    45 - 48", "depth hoar",
                  "energy, WEAC", "measured: PST 32/100 (End) at 45 cm: computed over measured", "variance",
                  "assumed: density by hardness and form"):
        assert words in done.output
    values = json.loads((tmp_path / "out" / "stability.json").read_text(encoding="utf-8"))
    assert values["weak_layer"]["top"] == 0.45
    assert set(values["critical_cut_length"]) >= {"strength", "energy"}
    for name in ("profile.png", "saw_test.toml", "slab_release.toml"):
        assert (tmp_path / "out" / name).stat().st_size > 1000
    assert cli("check", str(tmp_path / "out" / "saw_test.toml")).exit_code == 0


def test_numbers_as_json_are_those_of_the_file(cli, tmp_path):
    path = write(tmp_path)
    done = cli("profile", str(path), "-o", str(tmp_path / "out"), "--json")
    told = json.loads(done.stdout)
    kept = json.loads((tmp_path / "out" / "stability.json").read_text(encoding="utf-8"))
    assert {name: told[name] for name in kept} == kept


def test_layer_slope_and_law_are_the_users(cli, tmp_path):
    path = write(tmp_path)
    done = cli("profile", str(path), "-o", str(tmp_path / "out"), "--layer", "20", "--slope", "25", "--modulus",
               "scapozza")
    assert done.exit_code == 0
    values = json.loads((tmp_path / "out" / "stability.json").read_text(encoding="utf-8"))
    assert (values["weak_layer"]["top"], values["slab"]["angle"]) == (0.15, 25.0)
    assert "Scapozza" in values["slab"]["modulus_law"]
    assert "not written: no release on 25 degrees" in done.output
    assert not (tmp_path / "out" / "slab_release.toml").exists()


@pytest.mark.parametrize(("options", "message"), [
    (("--layer", "5"), "--layer = 5.0: must be from 15 to below 90 cm"),
    (("--layer", "95"), "--layer = 95.0"),
    (("--modulus", "steel"), "--modulus = 'steel': must be one of bergfeld, scapozza"),
    (("--time", "x"), "--time x: "),
    (("--resume",), "--resume: goes with --all"),
    (("--workers", "2"), "--workers: goes with --all"),
    (("--slope", "75"), "--slope = 75.0: must be from 0 to 70 degrees"),
    (("--all", "--run"), "--run: goes with one profile, not with --all"),
])
def test_refused_and_nothing_written(cli, tmp_path, options, message):
    path = write(tmp_path)
    done = cli("profile", str(path), "-o", str(tmp_path / "out"), *options)
    assert done.exit_code == 2
    assert message in done.output
    assert not (tmp_path / "out").exists()


def test_a_profile_without_a_weak_layer_is_drawn_and_says_how_to_name_one(cli, tmp_path):
    path = write(tmp_path, text=caaml([(0, 20, "RG", 0.3, "1F", None), (20, 60, "RG", 0.3, "P", None)], tests=()))
    done = cli("profile", str(path), "-o", str(tmp_path / "out"))
    assert done.exit_code == 0
    assert "No candidate for the weak layer" in done.output
    assert "--layer CM names one" in done.output
    assert sorted(file.name for file in (tmp_path / "out").glob("*.*") if file.name[0] != ".") == [
        "profile.png", "stability.json"]
    done = cli("profile", str(path), "-o", str(tmp_path / "out"), "--layer", "30")
    assert done.exit_code == 0
    assert "Weak layer at 20 cm" in done.output


def test_wet_snow_and_a_crack_that_arrested_are_told(cli, tmp_path):
    text = caaml().replace(">PP<", ">MFpc<").replace(">End<", ">Arr<")
    done = cli("profile", str(write(tmp_path, text=text)), "-o", str(tmp_path / "out"))
    assert "moist or wet snow" in done.output
    assert "PST 32/100 (Arr) at 45 cm: the crack did not run to the end" in done.output


def test_a_file_of_the_user_is_kept(cli, tmp_path):
    path = write(tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "profile.png").write_text("mine")
    done = cli("profile", str(path), "-o", str(tmp_path / "out"))
    assert done.exit_code == 2
    assert (tmp_path / "out" / "profile.png").read_text() == "mine"


def test_a_folder_becomes_one_table(cli, pits, tmp_path):
    done = cli("profile", "--all", str(pits), "-o", str(tmp_path / "out"))
    assert done.exit_code == 0, done.output
    with (tmp_path / "out" / "profiles.csv").open(encoding="utf-8") as file:
        rows = {row["file"].rpartition("/")[2]: row for row in csv.DictReader(file)}
    assert len(rows) == 6
    assert "not valid XML" in rows["broken.xml"]["cannot"]
    assert "density is missing" in rows["unknown.xml"]["cannot"]
    assert float(rows["steep.xml"]["slope_angle_deg"]) == 42.0
    assert (rows["pit.xml"]["test"], rows["pit.xml"]["cut_m"]) == ("PST End", "0.32")
    assert rows["pit.pro"]["test"] == ""
    assert float(rows["pit.xml"]["strength_low_m"]) < float(rows["pit.xml"]["strength_m"])
    assert "6 profiles, 6 rows, of which 2 are not evaluated:" in done.output
    assert (tmp_path / "out" / "profiles.png").stat().st_size > 5000


def test_resume_does_only_what_is_missing(pits, tmp_path, monkeypatch):
    target, done = tmp_path / "out", []
    whole = batch.run(pits, target, quiet=True)
    table = (target / "profiles.csv").read_text()
    with pytest.raises(InputError, match="--resume goes on with it"):
        batch.run(pits, target, quiet=True)
    lines = (target / "results.jsonl").read_text().splitlines(keepends=True)
    (target / "results.jsonl").write_text("".join(lines[:3]) + lines[3][:40])  # killed as it wrote the fourth
    rows_of = batch.rows_of
    monkeypatch.setattr(batch, "rows_of", lambda job: done.append(job) or rows_of(job))
    again = batch.run(pits, target, resume=True, quiet=True)
    assert len(done) == 3
    assert again.record == whole.record
    assert (target / "profiles.csv").read_text() == table
    changed = pits / "pit.csv"
    changed.write_text(changed.read_text().replace("slope_angle = 36", "slope_angle = 40"))
    batch.run(pits, target, resume=True, quiet=True)
    assert len(done) == 4
    batch.run(pits, target, resume=True, modulus="gerling", quiet=True)
    assert len(done) == 10


def test_the_command_resumes_what_it_wrote_itself(cli, pits, tmp_path):
    words = ("profile", "--all", str(pits), "-o", str(tmp_path / "out"))
    assert cli(*words).exit_code == 0
    assert cli(*words).exit_code == 2  # not anew over it
    (pits / "later.csv").write_text(CSV, encoding="utf-8")
    done = cli(*words, "--resume")
    assert done.exit_code == 0, done.output
    assert "7 profiles" in done.output


def test_a_killed_line_does_not_swallow_the_next(pits, tmp_path):
    target = tmp_path / "out"
    batch.run(pits, target, quiet=True)
    lines = (target / "results.jsonl").read_text().splitlines(keepends=True)
    (target / "results.jsonl").write_text("".join(lines[:3]) + lines[3][:40])
    for _ in range(2):
        batch.run(pits, target, resume=True, quiet=True)
    assert len((target / "results.jsonl").read_text().splitlines()) == 6


def test_whatever_a_file_does_the_others_go_on(pits, tmp_path, monkeypatch):
    """Encodings that Python does not have, names that are no text, pipes, links to elsewhere, faults of our own."""
    outside = write(tmp_path, "outside.csv", CSV)
    (pits / "link.csv").symlink_to(outside)
    write(pits, "odd.xml", caaml().replace("UTF-8", "x-foo"))
    write(pits, "japan.xml", caaml().replace("UTF-8", "shift_jis"))
    os.mkfifo(pits / "pipe.csv")
    (pits / os.fsdecode(b"\xff.csv")).write_text(CSV, encoding="utf-8")
    real = batch.read_profile
    monkeypatch.setattr(batch, "read_profile", lambda path: 1 / 0 if str(path).endswith("steep.xml") else real(path))
    found = batch.run(pits, tmp_path / "out", workers=1, quiet=True)
    with (tmp_path / "out" / "profiles.csv").open(encoding="utf-8") as file:
        cannot = {row["file"].rpartition("/")[2]: row["cannot"] for row in csv.DictReader(file)}
    assert found.record["profiles"] == 10  # without the link
    assert "encoding cannot be read" in cannot["odd.xml"] and "encoding cannot be read" in cannot["japan.xml"]
    assert cannot["pipe.csv"] == "not a file"
    assert "ZeroDivisionError" in cannot["steep.xml"]
    assert cannot["\\udcff.csv"] == "" == cannot["pit.csv"]


@pytest.mark.parametrize("change", [
    lambda row: row.pop("file"), lambda row: row.update(cut_m="x"), lambda row: row.update(cannot=5),
    lambda row: row.update(file=[1]), lambda row: row.update(column_m=-1.0), lambda row: row.update(other=1)])
def test_results_that_somebody_changed_are_refused(pits, tmp_path, change):
    target = tmp_path / "out"
    batch.run(pits, target, workers=1, quiet=True)
    lines = (target / "results.jsonl").read_text().splitlines()
    entry = json.loads(lines[0])
    change(entry["rows"][0])
    (target / "results.jsonl").write_text("\n".join([json.dumps(entry), *lines[1:]]) + "\n")
    with pytest.raises(InputError, match=r"results.jsonl: line 1: not written by this program"):
        batch.run(pits, target, resume=True, quiet=True)


@pytest.mark.slow
def test_the_saw_test_of_the_profile_is_run_and_told(cli, tmp_path):
    """Critical length of the interface, and whether it ran to the end: that of the guide, to two bins of the record."""
    pytest.importorskip("weac")
    done = cli("profile", str(ROOT / "docs" / "snow_pit.csv"), "-o", str(tmp_path / "out"), "--run")
    assert done.exit_code == 0, done.output
    assert "saw test by MPM, weak layer as an interface: critical length" in done.output
    values = json.loads((tmp_path / "out" / "stability.json").read_text(encoding="utf-8"))
    length = values["interface"]["critical_length"]
    assert length == pytest.approx(0.52, abs=0.04)
    assert values["critical_cut_length"]["weac"]["value"] == pytest.approx(0.42, abs=0.005)
    assert "finds 0.52 m (12 s), beside 0.42 m by WEAC" in (ROOT / "docs" / "snow_pits.md").read_text(encoding="utf-8")
    assert values["interface"]["runs_to_the_end"] is True


@pytest.mark.slow
def test_workers_find_the_same(pits, tmp_path):
    pytest.importorskip("distributed")
    alone = batch.run(pits, tmp_path / "alone", workers=1, quiet=True)
    together = batch.run(pits, tmp_path / "together", workers=2, quiet=True)
    assert alone.record == together.record
    assert (tmp_path / "alone" / "profiles.csv").read_text() == (tmp_path / "together" / "profiles.csv").read_text()


def test_statistics_count_what_they_say():
    rows = [{"test": "End", "cut_m": cut, "column_m": 1.0, "energy_m": found, "energy_low_m": 0.5 * found,
             "energy_high_m": 1.2 * found} for cut, found in (
                 (0.2, 0.2), (0.3, 0.5), (0.4, 0.4), (0.5, 0.7), (0.6, 0.95), (0.9, 0.1))]
    rows += [{"test": "Arr", "cut_m": 0.5, "column_m": 1.0, "energy_m": 0.5}, {"cannot": "why"},
             {"test": "End", "cut_m": 0.5, "column_m": 1.0, "energy_m": 0.0, "energy_low_m": 0.0, "energy_high_m": 0.6}]
    found = batch.statistics(rows)["energy"]
    assert (found["n"], found["fails_by_itself"]) == (6, 1)
    assert found["median_ratio"] == pytest.approx(1.4)
    assert found["within_factor"] == pytest.approx(3 / 5)  # 1, 1, 1.4; not 1.67 and 1.58
    assert found["within_interval"] == pytest.approx(6 / 6)
    assert found["rank_correlation"] == pytest.approx(0.9)
    assert batch.statistics(rows, near_end=True)["energy"]["n"] == 7


def test_cells_are_no_formulas():
    for text in ("=1+1", "+1", "-1", "@x", "\tx"):
        assert batch.cell_text(text) == f"'{text}"
    assert batch.cell_text(None) == batch.cell_text("") == ""
    assert batch.cell_text(-1.5) == "-1.5"


@pytest.mark.parametrize(("make", "message"), [
    (lambda folder: folder, "no profiles in it"), (lambda folder: folder / "none", "--all takes a folder")])
def test_a_folder_without_profiles(cli, tmp_path, make, message):
    done = cli("profile", "--all", str(make(tmp_path)), "-o", str(tmp_path / "out"))
    assert done.exit_code == 2
    assert message in done.output


def test_a_profile_of_a_model(cli, tmp_path):
    path = write(tmp_path, "pit.pro", PRO)
    done = cli("profile", str(path), "-o", str(tmp_path / "out"), "--time", "28.01.2026")
    assert done.exit_code == 0
    assert "(SNOWPACK): 28.01.2026 12:00" in done.output

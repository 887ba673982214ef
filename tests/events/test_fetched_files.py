"""Files of events: fetched once, checked, taken from a folder of the user; and all that may be wrong with them."""

import gzip
import os
import re
import shutil

import pytest

from snowmpm.errors import InputError
from snowmpm.events import store
from snowmpm.scenes import load_scene
from tests.support.made_up_event import EVENT, NAME

RASTER = "valley.asc"


def test_files_are_fetched_once_and_make_a_scene(made_up, server, capsys):
    name = made_up()
    scene = load_scene(f"event:{name}")
    assert scene.name == "made_up" and scene.base_dir == store.kept(name)
    assert sorted(server.asked) == ["seen.geojson", "valley.asc", "valley_release.geojson"]
    assert "fetching valley.asc" in capsys.readouterr().err
    load_scene(f"event:{name}", {"solver.dx": 20.0})
    assert len(server.asked) == 3


def test_a_kept_file_that_was_changed_is_fetched_anew(made_up, server):
    path = store.scene_file(made_up())
    with (path.parent / RASTER).open("ab") as file:
        file.write(b"1")
    store.scene_file(NAME)
    assert server.asked.count(RASTER) == 2 and server.asked.count("seen.geojson") == 1


def test_files_of_the_users_folder_need_no_network(made_up, server, own):
    name = made_up()
    for path in server.folder.iterdir():
        (own / name / path.name).write_bytes(path.read_bytes())
    store.scene_file(name)
    assert server.asked == []


def test_a_raster_without_a_system_gets_that_of_the_registry(made_up, server, own):
    name = made_up()
    path = own / name / "event.toml"
    text = re.sub('(name = "valley.asc"\n)', '\\1crs = "EPSG:31287"\n', path.read_text(encoding="utf-8"))
    path.write_text(text, encoding="utf-8")
    assert "Lambert" in (store.scene_file(name).parent / "valley.prj").read_text(encoding="utf-8")


def refused(call, *words):
    """The one or two lines of a command that is refused."""
    code, out, err = call("events", "get", NAME, *words)
    lines = [line for line in err.splitlines() if not line.startswith("fetching")]
    assert code == 2 and out == "" and 1 <= len(lines) <= 2 and lines[0].startswith("error: "), err
    return " ".join(lines)


@pytest.mark.parametrize(("answer", "words"), [
    ((404, b"", None), "answers 404"),
    ((200, b"ncols 96\nnrows 52\n", None), "it is not whole"),
    ((200, b"ncols 96\nnrows 52\n", 100_000), "valley.asc.*(not whole|broke off|no connection)"),
], ids=["not there", "a partial file", "a connection that breaks off"])
def test_what_a_server_may_do(made_up, server, call, answer, words):
    made_up()
    server.answers[RASTER] = answer
    assert re.search(words, refused(call))
    assert not (store.kept(NAME) / RASTER).exists()


def test_another_checksum(made_up, server, call):
    made_up()
    content = (server.folder / RASTER).read_bytes()
    server.answers[RASTER] = (200, content[:-3] + b"7" + content[-2:], None)
    assert "has another checksum than the registry's: not kept" in refused(call)
    assert not (store.kept(NAME) / RASTER).exists()


def test_a_file_without_end_is_not_read_to_its_end(made_up, server, call):
    made_up()
    server.answers[RASTER] = (200, b"0 " * (8 << 20), None)
    assert re.search(r"has \d+ bytes and not", refused(call))


def test_no_network(made_up, server, own, call):
    name = made_up()
    path = own / name / "event.toml"
    path.write_text(path.read_text(encoding="utf-8").replace(server.address, "http://127.0.0.1:9"), encoding="utf-8")
    said = refused(call)
    assert "no connection to 127.0.0.1" in said and "SNOWMPM_EVENTS" in said


def test_a_licence_that_must_be_accepted(made_up, call):
    made_up(accept=True)
    said = refused(call)
    assert "must be accepted" in said and f"snowmpm events get {NAME} --accept-licence" in said
    code, out, _ = call("events", "get", NAME, "--accept-licence")
    assert code == 0 and "CC0: anything" in out
    assert call("events", "get", NAME)[0] == 0  # once


def test_a_partial_file_in_the_users_folder(made_up, own, call):
    name = made_up()
    (own / name / RASTER).write_bytes(b"ncols 96\n")
    said = refused(call)
    assert str(own / name / RASTER) in said and "not whole" in said


def test_a_file_that_the_user_must_bring(made_up, own, server, call):
    brought = '\n[[brought]]\nname = "dem.asc"\nwhat = "a raster"\nsource = "the survey"\ncrs = "EPSG:31287"\n'
    made_up(event=EVENT.replace("[observed]", f"{brought}\n[observed]"))
    said = refused(call)
    assert "needs dem.asc" in said and "a raster, from the survey" in said and str(store.kept(NAME) / "dem.asc") in said
    (own / NAME / "dem.asc").write_bytes((server.folder / RASTER).read_bytes())
    assert call("events", "get", NAME)[0] == 0
    assert (store.kept(NAME) / "dem.prj").is_file()


@pytest.mark.parametrize(("old", "new", "words"), [
    ('name = "valley.asc"', 'name = "../valley.asc"', "files.1.name"),
    ('name = "valley.asc"', 'name = "event.toml"', "names a file twice"),
    ("http://127.0.0.1", "http://192.168.0.1", "must be an https address"),
    ("http://127.0.0.1", "file:///etc/passwd#", "must be an https address"),
    ('file = "seen.geojson"', 'file = "/etc/passwd"', "observed.outline.file"),
    ("uncertainty = 20.0", "uncertainty = 0.0", "must be > 0"),
    ('map = "peak_speed"', 'map = "speed"', "observed.values.0.map"),
    ("y = 200220.0\nwithin", "within", "needs both x and y"),
    ("path = ", "way = ", "way"),
])
def test_descriptions_that_are_none(made_up, own, call, old, new, words):
    name = made_up()
    path = own / name / "event.toml"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    said = refused(call)
    assert "event.toml" in said and words in said


def test_an_unknown_event(own, call):
    code, _, err = call("run", "event:ryggfon_2021")
    assert code == 2 and "did you mean ryggfonn_2021?" in err and len(err.splitlines()) == 1


def test_a_folder_of_events_that_is_none(own, call, monkeypatch):
    monkeypatch.setenv(store.VARIABLE, str(own / "nowhere"))
    code, _, err = call("events")
    assert code == 2 and "must be a folder" in err


def test_a_scene_cannot_name_an_event_by_a_path(own):
    with pytest.raises(InputError, match="no event"):
        load_scene("event:../made_up")


@pytest.mark.parametrize("name", sorted(store.events()))
def test_events_of_the_library_can_be_told(name, call):
    code, out, _ = call("events", "show", name)
    assert code == 0 and "assumed" in out
    one = store.event(name)
    assert one.licence in out and one.credit in out
    assert all(re.search("/[0-9a-f]{40}/", source.url) for source in one.files)  # which nobody changes


def test_the_list_of_events(made_up, call):
    made_up()
    code, out, _ = call("events")
    assert code == 0 and "ryggfonn_2021" in out and "A made-up avalanche" in out and "fetched when used" in out
    store.scene_file(NAME)
    assert "licence CC0; files are here" in call("events")[1]


def test_a_redirect_is_not_read(made_up, server, call):
    """Its body may be anything, and `requests` would unpack it."""
    made_up()
    bomb = gzip.compress(bytes(64 << 20))
    server.headers["moved.asc"] = {"Location": f"{server.address}/valley.asc", "Content-Encoding": "gzip"}
    server.answers["moved.asc"] = (302, bomb, None)
    server.headers[RASTER] = {"Location": f"{server.address}/moved.asc"}
    server.answers[RASTER] = (302, b"", None)
    assert "leads on more than 5 times" in refused(call)
    server.answers["moved.asc"] = (200, (server.folder / RASTER).read_bytes(), None)
    assert call("events", "get", NAME)[0] == 0


def test_what_is_packed_is_not_unpacked(made_up, server, call):
    made_up()
    server.headers[RASTER] = {"Content-Encoding": "gzip"}
    server.answers[RASTER] = (200, gzip.compress(bytes(64 << 20))[:30_000], None)
    assert "not whole" in refused(call)


@pytest.mark.parametrize("place", ["http://[bad", "file:///etc/passwd", "http://x..y/", "ftp://127.0.0.1/a"])
def test_where_a_server_may_not_lead(made_up, server, call, place):
    made_up()
    server.headers[RASTER], server.answers[RASTER] = {"Location": place}, (302, b"", None)
    assert re.search("may not come from|Invalid IPv6", refused(call))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
@pytest.mark.parametrize("file", ["event.toml", "scene.toml", "valley.asc"])
@pytest.mark.parametrize("kind", ["link", "pipe", "large"])
def test_only_plain_files_of_a_bounded_size_are_read(made_up, own, call, tmp_path, file, kind):
    name = made_up()
    path = own / name / file
    path.unlink(missing_ok=True)
    if kind == "link":
        path.symlink_to(tmp_path / "served" / "valley.asc")
    elif kind == "pipe":
        os.mkfifo(path)
    else:
        with path.open("wb") as sparse:
            sparse.truncate(2 << 30)
    said = refused(call)
    assert str(path) in said and ("must be a file, no link" in said or "at most" in said)


def test_another_event_of_a_name_of_the_library(made_up, own, call):
    shutil.copytree(own / made_up(), own / "ryggfonn_2021")
    code, _, err = call("events", "show", "ryggfonn_2021")
    assert code == 2 and "another event of this name comes with the program" in err


def test_an_event_that_cannot_be_read_does_not_hide_the_others(made_up, own, call):
    (own / made_up() / "event.toml").write_text("title = 5", encoding="utf-8")
    code, out, _ = call("events")
    assert code == 0 and "ryggfonn_2021" in out and "warning: " in out and "made_up" in out
    assert "cannot be read" in call("list")[1]


def test_an_event_without_files_to_fetch_is_used_where_it_is(made_up, server, own, call):
    name = made_up(files="")
    for path in server.folder.iterdir():
        shutil.copy(path, own / name)
    assert store.scene_file(name) == own / name / "scene.toml"
    assert call("events", "get", name)[0] == 0 and "files are here" in call("events")[1]


@pytest.mark.parametrize(("old", "new", "words"), [
    ("path = [[600110.0", "path = [[100110.0", "observed.path"),
    ("x = 600400.0", "x = 700400.0", "observed.values.0"),
    ("uncertainty = 20.0", "uncertainty = 900.0", "is wider than the area itself"),
    ("[600500.0, 200220.0], [600950.0, 200220.0]", "[600110.0, 200250.0]", "no corner twice"),
])
def test_observations_beside_the_terrain(made_up, own, call, old, new, words):
    name = made_up()
    path = own / name / "event.toml"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    assert words in refused(call)


def test_a_stop_far_from_the_path(made_up, call):
    made_up(observed="stopped = { x = 600500.0, y = 201800.0, uncertainty = 10.0 }")
    assert "beside the path: at most 500 m" in refused(call)


@pytest.mark.parametrize(("way", "words"), [
    ('"samos_at_small" = { "terrain.friction" = 0.9 }', "is the name of a way of the program"),
    ('"mine" = { "terrain.frction" = 0.9 }', "ways.'mine'"),
])
def test_ways_that_an_event_may_not_have(made_up, call, way, words):
    doubled = way.replace("{", "{{").replace("}", "}}")
    name = made_up(event=EVENT.replace("[observed]\n", f"[ways]\n{doubled}\n[observed]\n"))
    code, _, err = call("events", "score", name)
    assert code == 2 and words in err

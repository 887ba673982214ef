"""Files of events: fetched once, checked, taken from a folder of the user; and all that may be wrong with them."""

import re

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
    ((302, b"http://example.org/valley.asc", None), "valley.asc"),
], ids=["not there", "a partial file", "a connection that breaks off", "sent elsewhere, without encryption"])
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

"""The plugin for QGIS: what it knows of snowmpm, everywhere; each algorithm in QGIS itself, where there is one."""

import ast
import configparser
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

import snowmpm
from tests.support.project import ROOT
from tests.support.qgis import in_qgis, needs_qgis, surroundings

FOLDER = ROOT / "integrations" / "qgis"
PLUGIN = FOLDER / "snowmpm_qgis"
DRIVER = ROOT / "tests" / "integrations" / "drive_qgis.py"
LIBRARY = ROOT / "scenes" / "library"
BOWL = ("POLYGON((600110 200190,600150 200170,600230 200185,600260 200240,600235 200330,600150 200345,600115 200300,"
        "600110 200190))")
PART = "POLYGON((600160 200200,600220 200200,600220 200280,600160 200280,600160 200200))"
LAMBERT = "EPSG:31287"


def constants(module):
    """Constants of a module of the plugin by name, without QGIS."""
    found = {}
    for node in ast.parse((PLUGIN / f"{module}.py").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            try:
                found[node.targets[0].id] = ast.literal_eval(node.value)
            except ValueError:
                continue
    return found


def test_the_plugin_says_what_it_is():
    metadata = configparser.ConfigParser()
    metadata.read(PLUGIN / "metadata.txt", encoding="utf-8")
    general = metadata["general"]
    assert general["version"] == snowmpm.__version__
    assert general["hasProcessingProvider"] == "yes" and general["qgisMinimumVersion"] == "3.22"
    assert general["license"].startswith("GPL") and "GNU GENERAL PUBLIC LICENSE" in (PLUGIN / "LICENSE").read_text()
    assert (PLUGIN / general["icon"]).is_file()
    ElementTree.parse(PLUGIN / general["icon"])


def test_friction_and_numbers_are_those_of_the_program():
    cards = {path.stem for path in (LIBRARY / "friction").glob("*.toml")}
    assert set(constants("base")["CARDS"]) <= cards | {"samos_at_auto"}
    from snowmpm.quantities.table import NUMBERS, RASTERS
    from snowmpm.region.release_terrain import RULES

    assert constants("release_areas")["RULES"] == tuple(RULES)
    numbers, rasters = {one.name for one in NUMBERS}, {f"{one.name}.tif" for one in RASTERS} | {"avalanche.gpkg"}
    assert {name for name, _ in constants("avalanche")["NUMBERS"].values()} <= numbers
    assert {name for name, _ in constants("avalanche")["MAPS"].values()} <= rasters


def test_it_does_without_what_qgis_may_not_have():
    """Neither snowmpm nor its packages are imported in QGIS's Python, and no name of PyQt5 alone."""
    for path in PLUGIN.glob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"import (snowmpm|numpy|taichi|shapely|h5py)\b|from PyQt[56]", text), path
        for node in ast.walk(ast.parse(text, feature_version=(3, 9))):
            assert not isinstance(node, getattr(ast, "Match", ())), path


def test_the_zip_holds_the_plugin_and_its_help(tmp_path):
    subprocess.run([sys.executable, FOLDER / "build.py", "-o", tmp_path], check=True, capture_output=True)
    with zipfile.ZipFile(tmp_path / "snowmpm_qgis.zip") as archive:
        names = archive.namelist()
        page = archive.read("snowmpm_qgis/help.html").decode()
    assert {name.split("/")[0] for name in names} == {"snowmpm_qgis"}
    assert {f"snowmpm_qgis/{path.name}" for path in PLUGIN.glob("*.py")} <= set(names)
    assert {"snowmpm_qgis/metadata.txt", "snowmpm_qgis/LICENSE", "snowmpm_qgis/icon.svg"} <= set(names)
    sources = "".join(path.read_text() for path in PLUGIN.glob("*.py"))
    titles = re.findall(r'KEY, TITLE, GROUP = "\w+", "([^"]+)"', sources)
    assert len(titles) == 8
    assert all(f'id="{title.lower().replace(" ", "-")}">{title}</h3>' in page for title in titles)
    assert ".md" not in page and "<img" not in page


@needs_qgis
@pytest.mark.skipif(shutil.which("lrelease") is None, reason="needs lrelease of Qt")
def test_a_translation_is_shown(tmp_path):
    """Texts are written for Linguist; what is translated there is what QGIS shows in that language."""
    copy = tmp_path / "qgis"
    shutil.copytree(FOLDER, copy)
    (tmp_path / "docs").mkdir()
    subprocess.run([sys.executable, copy / "build.py", "--texts", "de"], check=True, capture_output=True)
    path = copy / "snowmpm_qgis" / "i18n" / "snowmpm_de.ts"
    assert path.read_text(encoding="utf-8").count("<message>") > 100
    for source, translated in (("Maps of a run", "Karten einer Rechnung"), ("Results", "Ergebnisse")):
        text = path.read_text(encoding="utf-8")
        path.write_text(re.sub(f"(<source>{source}</source>\\s*)<translation [^>]*/>",
                               f"\\1<translation>{translated}</translation>", text), encoding="utf-8")
    subprocess.run([sys.executable, copy / "build.py", "--texts", "de"], check=True, capture_output=True)  # keeps them
    subprocess.run(["lrelease", path], check=True, capture_output=True)
    script = tmp_path / "names.py"
    script.write_text(NAMES_IN_GERMAN.format(plugins=str(copy)), encoding="utf-8")
    home = tmp_path / "home"
    home.mkdir(mode=0o700)
    assert in_qgis(script, [], home)["names"] == ["Karten einer Rechnung", "Ergebnisse", "Dam variants"]


NAMES_IN_GERMAN = """
import json, os, sys
sys.path[:0] = ["/usr/share/qgis/python/plugins", {plugins!r}]
from qgis.core import QgsApplication, QgsSettings
application = QgsApplication([], False)
application.initQgis()
QgsSettings().setValue("locale/userLocale", "de_AT")
from snowmpm_qgis.plugin import Plugin
plugin = Plugin(None)
plugin.initProcessing()
made = QgsApplication.processingRegistry().algorithmById
print(json.dumps({{"names": [made("snowmpm:maps").displayName(), made("snowmpm:maps").group(),
                            made("snowmpm:dam_variants").displayName()]}}))
sys.stdout.flush()
os._exit(0)
"""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The made-up valley as a GeoTIFF in Lambert, and in degrees."""
    rasterio = pytest.importorskip("rasterio")
    from rasterio.warp import Resampling, calculate_default_transform, reproject

    folder = tmp_path_factory.mktemp("layers")
    with rasterio.open(LIBRARY / "valley.asc") as source:
        values, profile = source.read(1), {**source.profile, "driver": "GTiff", "crs": LAMBERT}
        where = calculate_default_transform(LAMBERT, "EPSG:4326", source.width, source.height, *source.bounds)
    with rasterio.open(folder / "dem.tif", "w", **profile) as file:
        file.write(values, 1)
    transform, width, height = where
    degrees = {**profile, "crs": "EPSG:4326", "transform": transform, "width": width, "height": height}
    with rasterio.open(folder / "degrees.tif", "w", **degrees) as file:
        reproject(values, rasterio.band(file, 1), src_transform=profile["transform"], src_crs=LAMBERT,
                  src_nodata=profile["nodata"], dst_transform=transform, dst_crs="EPSG:4326",
                  dst_nodata=profile["nodata"], resampling=Resampling.bilinear)
    return folder


def layers(files, release=LAMBERT):
    """Layers of a project: terrain as a file, all others in memory."""
    fields = {"thickness": "double", "scenario": "string"}
    return [
        {"name": "dem", "uri": str(files / "dem.tif"), "provider": "gdal"},
        {"name": "degrees", "uri": str(files / "degrees.tif"), "provider": "gdal"},
        {"name": "release", "kind": "Polygon", "crs": release, "fields": fields,
         "features": [[BOWL, [1.5, "100 years"]]]},
        {"name": "two", "kind": "Polygon", "crs": release, "fields": fields,
         "features": [[BOWL, [1.5, "100 years"]], [PART, [None, "10 years"]]]},
        {"name": "beside", "kind": "Polygon", "crs": release, "features": [
            ["POLYGON((610000 200100,610100 200100,610100 200200,610000 200100))", []]]},
        {"name": "empty", "kind": "Polygon", "crs": release, "fields": fields, "features": []},
        {"name": "dams", "kind": "LineString", "crs": release, "fields": {"height": "double", "variant": "string"},
         "features": [["LINESTRING(600700 200120,600700 200280)", [12.0, "high up"]],
                      ["LINESTRING(600800 200120,600800 200280)", [None, "below"]]]},
        {"name": "seen", "kind": "Polygon", "crs": release, "features": [
            ["POLYGON((600110 200150,600900 200150,600900 200250,600110 200250,600110 200150))", []]]},
        {"name": "road", "kind": "LineString", "crs": release, "fields": {"name": "string"},
         "features": [["LINESTRING(600650 200100,600650 200320)", ["road"]]]},
    ]


def drive(tmp_path, files, work, project=LAMBERT, **more):
    """What QGIS made of the work."""
    command = Path(sys.executable).with_name("snowmpm.exe" if os.name == "nt" else "snowmpm")
    record = {"command": str(command), "project": project, "layers": layers(files), "work": work, **more}
    (tmp_path / "work.json").write_text(json.dumps(record))
    home = tmp_path / "home"
    home.mkdir(mode=0o700)
    return in_qgis(DRIVER, [FOLDER, tmp_path / "work.json"], home, timeout=900)["found"]


def names(tree):
    """Names of layers and groups under a node."""
    return [name for name, *rest in tree]


BASE = {"TERRAIN": "dem", "RELEASE": "release", "CELL": 20.0}


@needs_qgis
def test_an_avalanche_from_layers_of_the_project(tmp_path, files):
    """Terrain and a layer in memory become a run; its layers lie in a group, in order, with styles and system. Inputs
    that cannot be are refused with the words of the program, and nothing is added."""
    out = tmp_path / "out"
    strange = tmp_path / "strange"
    strange.mkdir()
    (strange / "mine.txt").write_text("mine")
    good, empty, wrong, kept = drive(tmp_path, files, [
        {"algorithm": "snowmpm:avalanche", "parameters": {**BASE, "THICKNESS_FIELD": "thickness", "OUTPUT": str(out)}},
        {"algorithm": "snowmpm:avalanche", "parameters": {**BASE, "RELEASE": "empty", "OUTPUT": str(tmp_path / "e")}},
        {"algorithm": "snowmpm:avalanche", "parameters": {**BASE, "RELEASE": "beside", "OUTPUT": str(tmp_path / "w")}},
        {"algorithm": "snowmpm:avalanche", "parameters": {**BASE, "OUTPUT": str(strange)}},
    ])
    assert good["fine"], good["log"]
    assert 600.0 < good["result"]["RUNOUT"] < 1000.0 and good["result"]["STATUS"].startswith("final")
    assert all(Path(good["result"][name]).is_file() for name in constants("avalanche")["MAPS"])
    group, children = good["tree"][0]
    assert group == "avalanche" and names(children)[:2] == ["run-out point", "run-out line"]
    assert names(children)[-1] == "terrain" and "peak pressure ρv² [Pa]" in names(children)
    assert all(valid and crs == LAMBERT for _, valid, _, crs in children)
    shares = good["shares"]
    assert shares == sorted(shares) and shares[-1] == pytest.approx(100.0) and len(shares) > 3
    assert any("came to rest" in line for line in good["log"])  # words of the program, as they are
    for failed, words in ((empty, "no polygon"), (wrong, "error: "), (kept, "holds files of others, such as mine.txt")):
        assert not failed["fine"] and any(words in line for line in failed["log"]), failed["log"]
        assert len(failed["tree"]) == len(good["tree"])
    assert sorted(os.listdir(strange)) == ["mine.txt"]


@needs_qgis
@pytest.mark.slow
def test_other_algorithms_and_projections(tmp_path, files):
    """Scenarios by attribute and by table, dams, a campaign, maps with gauges and over time, scores; terrain in
    degrees."""
    run = str(tmp_path / "avalanche")
    found = drive(tmp_path, files, [
        {"algorithm": "snowmpm:avalanche", "parameters": {**BASE, "TERRAIN": "degrees", "OUTPUT": run,
                                                          "FRICTION": "voellmy", "MU": 0.3, "XI": 1000.0}},
        {"algorithm": "snowmpm:scenarios", "parameters": {
            **BASE, "RELEASE": "two", "THICKNESS_FIELD": "thickness", "SCENARIO_FIELD": "scenario",
            "OUTPUT": str(tmp_path / "field")}},
        {"algorithm": "snowmpm:scenarios", "parameters": {
            **BASE, "SCENARIOS": ["10 years", 0.7, "", "30 years", "1,0", "samos_at_large"], "NAME": "periods",
            "OUTPUT": str(tmp_path / "table")}},
        {"algorithm": "snowmpm:dam_variants", "parameters": {
            **BASE, "DAMS": "dams", "DAM_HEIGHT_FIELD": "height", "VARIANT_FIELD": "variant",
            "OUTPUT": str(tmp_path / "dams")}},
        {"algorithm": "snowmpm:campaign", "parameters": {**BASE, "RUNS": 3, "OUTPUT": str(tmp_path / "campaign")}},
        {"algorithm": "snowmpm:maps", "parameters": {"RUN_FOLDER": run, "GAUGES": "road", "OVER_TIME": True,
                                                     "OUTPUT": str(tmp_path / "maps")}},
        {"algorithm": "snowmpm:compare_with_observed", "parameters": {"RUN_FOLDER": run, "OBSERVED": "seen",
                                                                      "OUTPUT": str(tmp_path / "seen")}},
        {"algorithm": "snowmpm:release_areas", "parameters": {"TERRAIN": "dem", "OUTPUT": str(tmp_path / "areas")}},
        {"algorithm": "snowmpm:release_areas", "parameters": {"TERRAIN": "degrees", "FOREST": "release",
                                                              "OUTPUT": str(tmp_path / "forest")}},
    ], picture=str(tmp_path / "map.png"))
    assert all(one["fine"] for one in found), [one["log"][-3:] for one in found if not one["fine"]]
    degrees, field, table, dams, campaign, maps, seen, areas, wooded = found
    assert names(areas["tree"][0][1]) == ["release areas"] and areas["result"]["COUNT"] > 1
    assert wooded["result"]["COUNT"] > 0
    assert any("is brought from EPSG:4326 to EPSG:31287" in line for line in degrees["log"])
    assert degrees["result"]["RUNOUT"] > 300.0
    for one, scenarios in ((field, ["100 years", "10 years"]), (table, ["10 years", "30 years"]),
                           (dams, ["without dams", "high up", "below"])):
        group = one["tree"][0][1]
        if one is dams:
            assert group.pop(0)[:3] == ["dams", True, True]
        assert names(group) == ["affected area", "above 1 kPa", "above 3 kPa", "above 10 kPa", "above 30 kPa",
                                *scenarios, "terrain"]
        head = Path(one["result"]["TABLE"]).read_text(encoding="utf-8").splitlines()[0]
        assert head == ",".join(["name", "label", "unit", *scenarios])
    assert table["tree"][0][0] == "periods"
    shares = names(campaign["tree"][0][1])
    assert shares[0] == "share of runs with a peak pressure ρv² of at least 1 kPa"
    assert campaign["tree"][0][1][0][2] and not campaign["tree"][0][1][1][2] and shares[-2:] == ["release", "terrain"]
    assert "gauge lines" in names(maps["tree"][0][1]) and "flow depth over time" in names(maps["tree"][0][1])
    assert 0.0 < seen["result"]["CRITICAL_SUCCESS_INDEX"] < 1.0 and "RUNOUT_DIFFERENCE" in seen["result"]
    assert "observed" in names(seen["tree"][0][1])
    assert (tmp_path / "map.png").stat().st_size > 5000


@needs_qgis
@pytest.mark.slow
def test_odd_inputs(tmp_path, files):
    """Results of an earlier run as inputs of the next in the same folder; terrain in degrees in a project of web maps;
    names twice, fields that are not there, tables of odd length, folders that cannot be."""
    out = tmp_path / "out"
    again = {**BASE, "OUTPUT": str(out)}
    table = {**BASE, "OUTPUT": str(tmp_path / "refused")}
    (tmp_path / "a_file").write_text("")
    found = drive(tmp_path, files, [
        {"algorithm": "snowmpm:avalanche", "parameters": {**again, "TERRAIN": "degrees"}},
        {"algorithm": "snowmpm:avalanche", "parameters": {**again, "TERRAIN": str(out / "terrain.tif"),
                                                          "RELEASE": str(out / "release.gpkg"), "THICKNESS": 0.7}},
        {"algorithm": "snowmpm:scenarios", "parameters": {**table, "SCENARIOS": ["a", 0.7, "", "a", 1.2, ""]}},
        {"algorithm": "snowmpm:scenarios", "parameters": {**table, "SCENARIOS": ["a", 0.7]}},
        {"algorithm": "snowmpm:scenarios", "parameters": {**table, "SCENARIO_FIELD": "nope"}},
        {"algorithm": "snowmpm:dam_variants", "parameters": {**table, "DAMS": "dams", "VARIANT_FIELD": "nope"}},
        {"algorithm": "snowmpm:avalanche", "parameters": {**table, "THICKNESS_FIELD": "nope"}},
        {"algorithm": "snowmpm:avalanche", "parameters": {**BASE, "OUTPUT": str(tmp_path / "a_file")}},
    ], project="EPSG:3857")
    first, second, *refused = found
    assert first["fine"], first["log"][-3:]
    assert any("from EPSG:4326 to EPSG:326" in line for line in first["log"])
    assert second["fine"], second["log"][-3:]
    assert 0.0 < second["result"]["RUNOUT"] < first["result"]["RUNOUT"]
    words = ("Scenario a is there twice", "has 2 cells", "has no attribute nope", "has no attribute nope",
             "has no attribute nope", "a_file")
    for one, said in zip(refused, words, strict=True):
        assert not one["fine"] and any(said in line for line in [one["error"], *one["log"]]), (said, one)


@needs_qgis
@pytest.mark.slow
def test_cancelling_ends_the_program(tmp_path, files):
    """A fine grid takes long; it is cancelled after some seconds, and no process of it is left."""
    out = tmp_path / "long"
    cancelled, = drive(tmp_path, files, [{"algorithm": "snowmpm:avalanche", "cancel": 12.0, "parameters": {
        **BASE, "CELL": 0.4, "OUTPUT": str(out)}}])
    assert not cancelled["fine"] and cancelled["seconds"] < 60.0
    assert any("Cancelled" in line for line in cancelled["log"]) and len(cancelled["tree"]) == len(layers(files))
    left = subprocess.run(["pgrep", "-f", str(out)], capture_output=True, text=True).stdout.split()
    assert left == []


@needs_qgis
@pytest.mark.slow
def test_every_algorithm_by_qgis_process(tmp_path, files):
    """Without a window and without a project, as a script calls them."""
    home = tmp_path / "home"
    home.mkdir(mode=0o700)
    release = tmp_path / "release.geojson"
    ring = [[float(x) for x in corner.split()] for corner in BOWL[len("POLYGON(("):-2].split(",")]
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::31287"}}
    for name, geometry in (("release", {"type": "Polygon", "coordinates": [ring]}),
                           ("dams", {"type": "LineString", "coordinates": [[600700, 200120], [600700, 200280]]})):
        (tmp_path / f"{name}.geojson").write_text(json.dumps({"type": "FeatureCollection", "crs": crs, "features": [
            {"type": "Feature", "properties": {"id": 1}, "geometry": geometry}]}))
    bin_ = tmp_path / "bin"
    bin_.mkdir()
    (bin_ / "snowmpm").symlink_to(Path(sys.executable).with_name("snowmpm"))
    environment = {**surroundings(home), "QGIS_PLUGINPATH": str(FOLDER), "PATH": f"/usr/bin:/bin:{bin_}"}
    program = "qgis_process.bin"  # Debian's wrapper qgis_process passes an option that it does not know

    def call(*words):
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, env=environment, timeout=600)
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-2000:]
        return done.stdout

    call("plugins", "enable", "snowmpm_qgis")
    listed = re.findall(r"snowmpm:(\w+)", call("list"))
    ground = [f"TERRAIN={files / 'dem.tif'}", f"RELEASE={release}", "CELL=20"]
    work = {
        "avalanche": ground, "scenarios": [*ground, "SCENARIOS=10 years,0.7,,30 years,1.0,"],
        "dam_variants": [*ground, f"DAMS={tmp_path / 'dams.geojson'}"], "campaign": [*ground, "RUNS=2"],
        "release_areas": [ground[0], "SCENARIO=rare", "SNOW=1.2"],
        "maps": [f"RUN_FOLDER={tmp_path / 'avalanche'}"],
        "compare_with_observed": [f"RUN_FOLDER={tmp_path / 'avalanche'}", f"OBSERVED={release}"]}
    assert sorted(listed) == sorted([*work, "set_up"])
    for name, words in work.items():
        told = call("run", f"snowmpm:{name}", "--", *words, f"OUTPUT={tmp_path / name}")
        assert "100 - done" in told and "Results" in told
    refused = subprocess.run([program, "run", "snowmpm:maps", "--", f"RUN_FOLDER={home}", f"OUTPUT={tmp_path / 'no'}"],
                             capture_output=True, text=True, env=environment, timeout=100)
    assert refused.returncode == 1 and "holds no run of snowmpm" in refused.stdout + refused.stderr

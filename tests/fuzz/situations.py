"""Commands in odd situations: environment, folders, files from elsewhere, limits of the system, two processes at once.

    python tests/fuzz/situations.py [--count 1000] [--seed 0] [--jobs 2]

Each try draws one of each kind, runs a command of snowmpm in a process of its own, and sorts the outcome:

    done          exit code 0, and what it should write is there and whole
    refused       exit code 2 with a message
    failed        exit code 1 with a message, 130 on interruption
    silent        exit code 0 without what it should write, with another mass and no warning, or nothing said
    traceback     a stack trace, "a fault of the program", or death by a signal that nobody sent
    lost          a file that was there before is changed or gone, and no option asked for it
    hang          nothing after TIME seconds

The last four are faults. Prints counts by kind, and each fault with what reproduces it.
"""

import argparse
import contextlib
import hashlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

TIME = 180.0
"""[s]"""

FAULTS = ("silent", "traceback", "lost", "hang")
MASS = 0.02
"""Relative difference of the mass from that of the plain files that must be told."""

SCENE = """
name = "path"
dimension = 3
end_time = 1.0
output = {{ interval = 0.5 }}
solver = {{ method = "depth", dx = 10.0 }}
materials.snow = {{ kind = "elastic", density = 200.0, youngs_modulus = 1e6, poisson_ratio = 0.3 }}
terrain = {{ kind = "dem", file = "{terrain}", friction = 0.3 }}
[[bodies]]
name = "release"
material = "snow"
shape = {{ kind = "layer", bottom = 0.0, top = "file", region = {{ file = "{release}" }} }}
"""

RING = [[60.0, 60.0], [120.0, 60.0], [120.0, 140.0], [60.0, 140.0], [60.0, 60.0]]


def heights():
    x, y = np.meshgrid(10.0 * np.arange(40), 10.0 * np.arange(20))
    return 900.0 - 0.6 * x + 2.0 * np.sin(y / 30.0)


def grid(z, nodata="-9999", end="\n", fmt="{:.2f}"):
    head = ["ncols 40", "nrows 20", "xllcorner 0", "yllcorner 0", "cellsize 10", f"NODATA_value {nodata}"]
    return end.join([*head, *(" ".join(fmt.format(v) for v in row) for row in z)]) + end


def polygons(properties=({"thickness": 1.0},), geometry=None, **more):
    features = [{"type": "Feature", "properties": own, "geometry": geometry or {
        "type": "Polygon", "coordinates": [RING]}} for own in properties]
    return json.dumps({"type": "FeatureCollection", "features": features, **more})


def gap(value):
    z = heights()
    z[8:12, 20:26] = value
    return z


def fifo(path):
    os.mkfifo(path)


def link_to(target):
    return lambda path: path.symlink_to(target)


TERRAINS = {
    "plain": lambda p: p.write_text(grid(heights())),
    "byte order mark": lambda p: p.write_bytes(b"\xef\xbb\xbf" + grid(heights()).encode()),
    "carriage returns": lambda p: p.write_bytes(grid(heights(), end="\r\n").encode()),
    "old carriage returns": lambda p: p.write_bytes(grid(heights(), end="\r").encode()),
    "utf-16": lambda p: p.write_text(grid(heights()), encoding="utf-16"),
    "decimal commas": lambda p: p.write_text(grid(heights()).replace(".", ",")),
    "tabs": lambda p: p.write_text(grid(heights()).replace(" ", "\t")),
    "capital head": lambda p: p.write_text(grid(heights()).replace("ncols", "NCOLS").replace("cellsize", "CELLSIZE")),
    "gap -32768": lambda p: p.write_text(grid(gap(-32768.0))),
    "gap 0": lambda p: p.write_text(grid(gap(0.0))),
    "gap nan": lambda p: p.write_text(grid(gap(np.nan))),
    "gap 3.4e38": lambda p: p.write_text(grid(gap(3.4e38), fmt="{:.6g}")),
    "all no data": lambda p: p.write_text(grid(np.full((20, 40), -9999.0))),
    "one value short": lambda p: p.write_text(grid(heights()).rstrip().rsplit(" ", 1)[0]),
    "one value long": lambda p: p.write_text(grid(heights()) + " 5"),
    "empty": lambda p: p.write_text(""),
    "a folder": lambda p: p.mkdir(),
    "a pipe": fifo,
    "endless": link_to("/dev/zero"),
    "dangling": link_to("nowhere.asc"),
    "circle": lambda p: p.symlink_to(p.name),
    "a tif by name": lambda p: p.write_bytes(b"II*\0" + bytes(200)),
    "web page": lambda p: p.write_text("<!DOCTYPE html><html>Not found</html>"),
    "millimetres": lambda p: p.write_text(grid(1000.0 * heights())),
    "prj in degrees": lambda p: (p.write_text(grid(heights())), p.with_suffix(".prj").write_text(
        'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],'
        'UNIT["degree",0.0174532925199433]]')),
    "prj of noise": lambda p: (p.write_text(grid(heights())), p.with_suffix(".prj").write_bytes(bytes(range(256)))),
}
RELEASES = {
    "plain": lambda p: p.write_text(polygons()),
    "byte order mark": lambda p: p.write_bytes(b"\xef\xbb\xbf" + polygons().encode()),
    "latin text": lambda p: p.write_bytes(
        polygons(({"name": "X", "thickness": 1.0},)).encode().replace(b'"X"', b'"\xfc"')),
    "d0": lambda p: p.write_text(polygons(({"d0": 1.0},))),
    "other name": lambda p: p.write_text(polygons(({"depth": 1.0},))),
    "decimal comma": lambda p: p.write_text(polygons(({"thickness": "1,0"},))),
    "text number": lambda p: p.write_text(polygons(({"thickness": "1.0"},))),
    "negative": lambda p: p.write_text(polygons(({"thickness": -1.0},))),
    "centimetres": lambda p: p.write_text(polygons(({"thickness": 150},))),
    "true": lambda p: p.write_text(polygons(({"thickness": True},))),
    "none": lambda p: p.write_text(polygons(({"thickness": None},))),
    "no properties": lambda p: p.write_text(polygons((None,))),
    "twice": lambda p: p.write_text(polygons(({"thickness": 1.0}, {"thickness": 1.0}))),
    "no geometry": lambda p: p.write_text(polygons(geometry={"type": "Point", "coordinates": [0, 0]})),
    "three numbers": lambda p: p.write_text(polygons(geometry={"type": "Polygon", "coordinates": [
        [[*c, 5.0] for c in RING]]})),
    "many": lambda p: p.write_text(polygons(geometry={"type": "MultiPolygon", "coordinates": [[RING]]})),
    "bow tie": lambda p: p.write_text(polygons(geometry={"type": "Polygon", "coordinates": [
        [[60.0, 60.0], [120.0, 140.0], [120.0, 60.0], [60.0, 140.0], [60.0, 60.0]]]})),
    "far away": lambda p: p.write_text(polygons(geometry={"type": "Polygon", "coordinates": [
        [[c[0] + 1e6, c[1]] for c in RING]]})),
    "degrees by its words": lambda p: p.write_text(polygons(crs={"type": "name", "properties": {
        "name": "urn:ogc:def:crs:OGC::CRS84"}})),
    "not closed": lambda p: p.write_text(polygons(geometry={"type": "Polygon", "coordinates": [RING[:-1]]})),
    "empty": lambda p: p.write_text(""),
    "a folder": lambda p: p.mkdir(),
    "a pipe": fifo,
    "endless": link_to("/dev/zero"),
    "cut": lambda p: p.write_text(polygons()[:-40]),
    "deep": lambda p: p.write_text("[" * 100_000),
}
SURROUNDINGS = {
    "plain": {}, "no home": {"HOME": None}, "home that is none": {"HOME": "/proc/none"}, "C locale": {"LC_ALL": "C"},
    "ascii output": {"PYTHONIOENCODING": "ascii"}, "no temporary folder": {"TMPDIR": "/proc/none"},
    "one column": {"COLUMNS": "1"}, "dumb terminal": {"TERM": "dumb"}, "no path": {"PATH": "/nowhere"},
    "threads that are none": {"OMP_NUM_THREADS": "x"}, "budget that is none": {"SNOWMPM_READ_GIB": "x"},
    "tiny budget": {"SNOWMPM_READ_GIB": "1e-9"}, "cache that is none": {"XDG_CACHE_HOME": "/proc/none"},
    "time zone": {"TZ": "Mars/Olympus"}, "no user": {"USER": None, "LOGNAME": None},
    "hash seed": {"PYTHONHASHSEED": "1"},
}
NAMES = ["plain", "with space", "süd", "雪", "-o", "a" * 200, "two\nlines", "[bold]x", "%s{0}$HOME", "'quoted\""]
"""Names of the folder of the scene."""

OUTPUTS = ["new", "there, empty", "own file in it", "a file", "the scene's folder", "a run", "a broken run",
           "below a file", "link"]
LIMITS = {
    "none": (), "few files": ((resource.RLIMIT_NOFILE, 24),), "small files": ((resource.RLIMIT_FSIZE, 20_000),),
    "smaller files": ((resource.RLIMIT_FSIZE, 1000),), "little memory": ((resource.RLIMIT_AS, 3_000_000_000),),
}
COMMANDS = ["check", "run", "run", "run", "run and resume", "two at once", "killed", "interrupted", "info", "maps",
            "plot", "new", "list", "docs"]
RESUMING = ("killed", "interrupted", "run and resume")


def prepared(root, draw):
    """Folder of a scene with its files, and the output folder, as drawn."""
    folder = root / draw["name"]
    folder.mkdir()
    terrain, release = folder / "dem.asc", folder / "release.geojson"
    TERRAINS[draw["terrain"]](terrain)
    RELEASES[draw["release"]](release)
    (folder / "scene.toml").write_text(SCENE.format(terrain="dem.asc", release="release.geojson"))
    (folder / "notes.txt").write_text("mine")
    out = folder / "out"
    kind = draw["output"]
    if kind == "there, empty":
        out.mkdir()
    elif kind == "own file in it":
        out.mkdir()
        (out / "summary.json").write_text("mine")
        (out / "run.vtkhdf").write_text("mine")
    elif kind == "a file":
        out.write_text("mine")
    elif kind == "the scene's folder":
        out = folder
    elif kind in ("a run", "a broken run"):
        shutil.copytree(draw["given"], out)
        if kind == "a broken run":
            data = (out / "run.vtkhdf").read_bytes()
            (out / "run.vtkhdf").write_bytes(data[: len(data) // 2])
    elif kind == "below a file":
        (folder / "plain").write_text("mine")
        out = folder / "plain" / "out"
    elif kind == "link":
        (folder / "elsewhere").mkdir()
        out.symlink_to("elsewhere")
    return folder, out


def files_of(folder):
    """{path: digest} of all files below a folder that were there before."""
    found = {}
    for path in folder.rglob("*"):
        if path.is_file() and not path.is_symlink():
            found[path] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def started(arguments, folder, draw):
    """A process of the command."""
    environment = dict(os.environ)
    for key, value in SURROUNDINGS[draw["surroundings"]].items():
        if value is None:
            environment.pop(key, None)
        else:
            environment[key] = value

    def limited():
        for which, limit in LIMITS[draw["limit"]]:
            resource.setrlimit(which, (limit, limit))

    return subprocess.Popen([sys.executable, "-m", "snowmpm", *arguments], cwd=folder, env=environment,
                            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            preexec_fn=limited, start_new_session=True)


def ended(process):
    """(code, output, messages) of a process; code None where it did not end."""
    try:
        out, err = process.communicate(timeout=TIME)
        return process.returncode, out.decode("utf-8", "replace"), err.decode("utf-8", "replace")
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        out, err = process.communicate()
        return None, out.decode("utf-8", "replace"), err.decode("utf-8", "replace")


def tried(draw):
    """(outcome, words) of one try."""
    with tempfile.TemporaryDirectory(dir=draw["scratch"]) as scratch:
        folder, out = prepared(Path(scratch), draw)
        before = files_of(folder)
        run = ["run", "scene.toml", "-o", str(out), "--threads", "1", "--progress", "lines"]
        command, sent = draw["command"], None
        read = str(out) if draw["output"] in ("a run", "a broken run") else str(draw["given"])
        arguments = {
            "check": ["check", "scene.toml"], "list": ["list"], "docs": ["docs", "--find", "friction"],
            "info": ["info", read], "maps": ["maps", read, "-o", str(folder / "maps_out")],
            "plot": ["plot", read, "-o", str(folder / "plot_out.png")],
            "new": ["new", "made", "--terrain", "dem.asc", "--release", "release.geojson", "--method", "depth"],
        }.get(command, run)
        first = started(arguments, folder, draw)
        others = []
        if command == "two at once":
            others = [started(arguments, folder, draw)]
        elif command in ("killed", "interrupted"):
            time.sleep(draw["delay"])
            sent = signal.SIGKILL if command == "killed" else signal.SIGINT
            with contextlib.suppress(ProcessLookupError):
                os.killpg(first.pid, sent)
        results = [ended(process) for process in (first, *others)]
        if command in RESUMING:
            results.append(ended(started([*run, "--resume"], folder, draw)))
        wanted = out if arguments is run else None
        found = [sorted_out(result, sent if i == 0 else None) for i, result in enumerate(results)]
        after = files_of(folder)
        goes_on = draw["output"] in ("a run", "a broken run") and command in RESUMING
        lost = [path for path, digest in before.items()
                if after.get(path) != digest and not (goes_on and out in path.parents)]
        if lost:
            return "lost", f"{lost[0].name}: {results}"
        worst = next((one for one in found if one in FAULTS), None)
        if worst:
            return worst, str(results[found.index(worst)])
        if wanted is not None and any(code == 0 for code, _, _ in results):
            told = "".join(err for _, _, err in results)
            if (why := incomplete(wanted, draw, told)) is not None:
                return "silent", f"{why}: {results}"
        return found[-1], ""


def sorted_out(result, sent):
    code, out, err = result
    text = out + err
    if code is None:
        return "hang"
    if "Traceback (most recent call last)" in text or "fault of the program" in text:
        return "traceback"
    if sent is not None and code in (-sent, 130, 0, 1, 2):
        return "failed"
    if code < 0 or (code > 2 and code != 130):
        return "traceback"
    if not text.strip():
        return "silent"
    return {0: "done", 2: "refused"}.get(code, "failed")


def incomplete(out, draw, told):
    """What is wrong with a run that is said to be done; None: nothing."""
    try:
        summary = json.loads((out / "summary.json").read_text())
    except (OSError, ValueError) as error:
        return f"no summary ({error})"
    if not summary.get("complete", True):
        return "not complete"
    mass = summary["last"].get("mass")
    if mass is not None and abs(mass / draw["mass"] - 1.0) > MASS and "warning" not in told:
        return f"mass {mass:.4g} for {draw['mass']:.4g}"
    return None


def draws(count, seed, scratch, given, mass):
    """Draws, of which a third is plain but in one thing."""
    rng = random.Random(seed)
    kinds = {"terrain": list(TERRAINS), "release": list(RELEASES), "surroundings": list(SURROUNDINGS), "name": NAMES,
             "output": OUTPUTS, "limit": list(LIMITS)}
    for i in range(count):
        draw = {kind: values[0] for kind, values in kinds.items()}
        chosen = rng.sample(list(kinds), rng.choice((1, 1, 2, 3)))
        draw |= {kind: rng.choice(kinds[kind]) for kind in chosen}
        yield draw | {"command": rng.choice(COMMANDS), "delay": rng.uniform(1.0, 9.0), "number": i, "scratch": scratch,
                      "given": given, "mass": mass}


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--count", type=int, default=1000)
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--jobs", type=int, default=2)
    asked = words.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        plain = Path(scratch, "given")
        plain.mkdir()
        TERRAINS["plain"](plain / "dem.asc")
        RELEASES["plain"](plain / "release.geojson")
        (plain / "scene.toml").write_text(SCENE.format(terrain="dem.asc", release="release.geojson"))
        subprocess.run([sys.executable, "-m", "snowmpm", "run", "scene.toml", "-o", "run", "-q", "--threads", "1"],
                       cwd=plain, check=True)
        mass = json.loads((plain / "run" / "summary.json").read_text())["last"]["mass"]
        counts, faults = Counter(), []
        with ThreadPoolExecutor(asked.jobs) as pool:
            todo = list(draws(asked.count, asked.seed, scratch, plain / "run", mass))
            for draw, (outcome, said) in zip(todo, pool.map(tried, todo), strict=True):
                counts[outcome] += 1
                if outcome in FAULTS:
                    faults.append(draw)
                    shown = {key: value for key, value in draw.items() if key not in ("scratch", "given", "mass")}
                    print(f"{outcome}: {shown}\n    {said[-1500:]}", flush=True)
                if sum(counts.values()) % 50 == 0:
                    print(dict(counts), flush=True)
        print(dict(counts))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

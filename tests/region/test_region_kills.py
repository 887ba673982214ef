"""Workers, scheduler and master of a region are killed at any moment: the same maps to the bit."""

import hashlib
import json

import pytest

pytest.importorskip("psutil")
pytest.importorskip("distributed")
pytest.importorskip("rasterio")

import rasterio

from snowmpm.region import launch, maps, plan
from snowmpm.region.spec import read_region
from tests.support.kills import killed
from tests.support.region import TEXT


def region(folder, terrain, releases):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "massif.tif").write_bytes(terrain.read_bytes())
    file = folder / "region.toml"
    file.write_text(TEXT.format(more="").replace("most_releases = 4", f"most_releases = {releases}"))
    return file


def digest(folder):
    """Of all maps and of the numbers of all runs."""
    found, setting = hashlib.sha256(), plan.read_setting(folder)
    for one in maps.rasters(setting):
        with rasterio.open(folder / plan.MAPS / f"{one.name}.tif") as file:
            found.update(file.read(1).tobytes())
    lines = {}
    for line in (folder / plan.RESULTS).read_text().splitlines():
        entry = json.loads(line)
        entry.pop("seconds")
        lines[entry["hash"]] = json.dumps(entry, sort_keys=True)
    for name in sorted(lines):
        found.update(lines[name].encode())
    return found.hexdigest(), len(lines)


def whole(folder, terrain, releases):
    launch.run_region(read_region(region(folder, terrain, releases)), folder / "out", workers=2)
    return digest(folder / "out")


def killed_region(folder, terrain, releases, kills, seed, scheduler):
    file, out = region(folder, terrain, releases), folder / "out"

    def again():
        """Forget half of the runs."""
        lines = (out / plan.RESULTS).read_text().splitlines(keepends=True)
        for line in lines[::2]:
            (plan.results_of(out, json.loads(line)["hash"]) / "record.json").unlink(missing_ok=True)
        (out / plan.RESULTS).write_text("".join(lines[1::2]))

    hit, code = killed(folder, ("region", str(file), "-o", str(out)), again, kills, seed, scheduler)
    return hit, code, digest(out)


def test_a_killed_master_changes_nothing(tmp_path, terrain):
    hit, code, found = killed_region(tmp_path / "killed", terrain, 4, 2, 1, False)
    assert code == 0 and sum(hit.values()) >= 2
    assert found == whole(tmp_path / "whole", terrain, 4)


@pytest.mark.slow
@pytest.mark.parametrize(("scheduler", "kills"), [(False, 40), (True, 20)], ids=["of this machine", "of a scheduler"])
def test_killed_at_any_moment(tmp_path, terrain, scheduler, kills):
    hit, code, found = killed_region(tmp_path / "killed", terrain, 24, kills, 3, scheduler)
    print(f"{hit} killed")
    assert code == 0 and sum(hit.values()) >= kills and min(hit.values()) >= 3
    assert found == whole(tmp_path / "whole", terrain, 24)

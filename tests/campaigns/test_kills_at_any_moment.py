"""Workers, scheduler and master are killed at any moment, while they start, run and merge: the same answer."""

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("psutil")
pytest.importorskip("distributed")

from tests.support.kills import killed

CAMPAIGN = """name = "killed"
scene = "avalanche_depth_averaged"
runs = 10
maps = { cell = 20.0 }
[set]
"solver.dx" = 20.0
"solver.particles_per_cell" = 2
"end_time" = 40.0
"output.interval" = 8.0
"terrain.friction" = { law = "voellmy", mu = 0.25, xi = 1500.0 }
[parameters.mu]
key = "terrain.friction.mu"
distribution = "uniform"
low = 0.2
high = 0.35
"""
def whole(folder):
    folder.mkdir()
    (folder / "campaign.toml").write_text(CAMPAIGN)
    subprocess.run([sys.executable, "-m", "snowmpm", "campaign", "run", str(folder / "campaign.toml"), "-o",
                    str(folder / "out"), "-q"], check=True, capture_output=True)
    return table(folder)


def table(folder):
    return (Path(folder) / "out" / "table.csv").read_text()


@pytest.mark.slow
@pytest.mark.parametrize(("scheduler", "kills"), [(False, 70), (True, 30)], ids=["of this machine", "of a scheduler"])
def test_killed_at_any_moment(tmp_path, scheduler, kills):
    folder = tmp_path / "killed"
    folder.mkdir()
    (folder / "campaign.toml").write_text(CAMPAIGN)

    def again():
        for record in sorted((folder / "out").glob("results/*/record.json"))[::2]:
            record.unlink()

    words = ("campaign", "run", str(folder / "campaign.toml"), "-o", str(folder / "out"))
    hit, code = killed(folder, words, again, kills, 3, scheduler)
    print(f"{hit} killed")
    assert code == 0 and sum(hit.values()) >= kills and min(hit.values()) >= 3
    assert table(tmp_path / "killed") == whole(tmp_path / "whole")

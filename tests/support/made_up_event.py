"""A made-up event: the library's valley, with an outline drawn by hand; and a server of its files."""

from dataclasses import dataclass, field
from pathlib import Path

NAME = "made_up"
SCENE = """name = "made_up"
dimension = 3
end_time = 60.0
[output]
interval = 10.0
[solver]
method = "depth"
dx = 10.0
[terrain]
kind = "dem"
file = "valley.asc"
friction = { card = "samos_at_auto" }
[materials.snow]
kind = "elastic"
density = 200.0
youngs_modulus = 1e6
poisson_ratio = 0.3
[[bodies]]
name = "release"
material = "snow"
shape = { kind = "layer", bottom = 0.0, top = 1.5, region = { file = "valley_release.geojson" } }
"""
EVENT = """title = "A made-up avalanche"
date = 2026-01-02
place = "nowhere"
kind = "made up"
credit = "nobody"
licence = "CC0"
terms = "https://creativecommons.org/publicdomain/zero/1.0/"
accept = {accept}
uses = "anything"
sources = ["this test"]
assumed = ["everything"]
{files}
[observed]
outline = {{ file = "seen.geojson", uncertainty = 20.0 }}
path = [[600110.0, 200250.0], [600500.0, 200220.0], [600950.0, 200220.0]]
{observed}
[[observed.values]]
map = "peak_speed"
x = 600400.0
y = 200220.0
within = 100.0
value = 30.0
deviation = 3.0
by = "hand"
"""
SEEN = {"type": "Polygon", "coordinates": [[[600110, 200170], [600300, 200170], [600800, 200180], [600800, 200260],
                                            [600300, 200330], [600110, 200330], [600110, 200170]]]}


@dataclass
class Server:
    """folder: of the files; answers: (status, body, length that is announced) of a file instead of it; headers: more of
    an answer."""

    folder: Path
    address: str = ""
    answers: dict = field(default_factory=dict)
    headers: dict = field(default_factory=dict)
    asked: list = field(default_factory=list)

    def answer(self, name):
        self.asked.append(name)
        if name in self.answers:
            return self.answers[name]
        path = self.folder / name
        return (200, path.read_bytes(), None) if path.is_file() else (404, b"", None)

"""What a run writes for each particle and frame, and how fast it is read: of library scenes, field by field.

    python tests/benchmarks/file_sizes.py [-o FILE]

Columns: scene; particles; frames; field ("all": together); numbers of a particle in a frame; raw and stored, its bytes
before and after compression (gzip 1 after the shuffle filter of HDF5), whole chunks included; frame_ns: ns a particle
to read it for a whole frame; piece_ms: to read 100 000 particles of a larger frame; checkpoint: bytes a particle of
checkpoint.npz. By h5py, on one thread; the file lies in the system's cache.
"""

import argparse
import csv
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np

from snowmpm.cli.app import app

SCENES = {"slab_release": {}, "column_collapse_3d": {}, "slab_release_resolved": {"end_time": 2.0}}
PIECE = 100_000
TABLE = Path(__file__).parent / "figures" / "file_sizes.csv"


def seconds(path, names, rows, times=3):
    """Least time to read rows of data sets [s]: the file is opened anew, so that nothing is kept uncompressed."""
    found = []
    for _ in range(times):
        with h5py.File(path) as file:
            begun = time.perf_counter()
            for name in names:
                file[name][rows]
            found.append(time.perf_counter() - begun)
    return min(found)


def rows_of(scene, path):
    """Rows of a run file."""
    with h5py.File(path) as file:
        names = ["VTKHDF/Points", *(f"VTKHDF/PointData/{name}" for name in file["VTKHDF/PointData"])]
        counts, start = file["VTKHDF/NumberOfPoints"][:], int(file["VTKHDF/Steps/PointOffsets"][-1])
        total, frames, count = int(counts.sum()), len(counts), int(counts[-1])
        numbers = {name: int(np.prod(file[name].shape[1:], dtype=int)) for name in names}
        raw = {name: numbers[name] * file[name].dtype.itemsize for name in names}
        stored = {name: file[name].id.get_storage_size() / total for name in names}
    whole, piece = slice(start, start + count), slice(start, start + PIECE)
    for field, read in [*((name.split("/")[-1], [name]) for name in names), ("all", names)]:
        yield {"scene": scene, "particles": count, "frames": frames, "field": field,
               "numbers": sum(numbers[name] for name in read), "raw": sum(raw[name] for name in read),
               "stored": sum(stored[name] for name in read),
               "frame_ns": 1e9 * seconds(path, read, whole) / count,
               "piece_ms": 1e3 * seconds(path, read, piece) if count > PIECE else "",
               "checkpoint": path.with_name("checkpoint.npz").stat().st_size / count if field == "all" else ""}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    options = parser.parse_args()
    options.output.parent.mkdir(parents=True, exist_ok=True)
    rows = []
    for scene, changes in SCENES.items():
        with tempfile.TemporaryDirectory() as folder:
            words = [f"--set={key}={value}" for key, value in changes.items()]
            if code := app(["run", scene, "-o", f"{folder}/run", "-q", *words], standalone_mode=False):
                raise SystemExit(f"{scene}: ended with {code}")
            rows += rows_of(scene, Path(folder) / "run" / "run.vtkhdf")
    with options.output.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows({key: f"{value:.3g}" if isinstance(value, float) else value for key, value in row.items()}
                        for row in rows)
    for row in rows:
        print(row)


if __name__ == "__main__":
    main()

"""matter's sources compiled with matter_run.cpp as its README says (Release), and run on one thread.

Its steps are half a cell of a wave long, its default, in double precision, its default too.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np

CHOICES = {"0.95 AFLIP": -0.95, "APIC": -1e-9}
"""`flip_ratio`: its default mixture of AFLIP and APIC, and APIC."""


def eigen():
    """The compiler's word for the headers of Eigen 3: the folder that EIGEN names, or what pkg-config says.

    Raises SystemExit without.
    """
    if folder := os.environ.get("EIGEN"):
        return [f"-I{folder}"]
    if shutil.which("pkg-config"):
        said = subprocess.run(["pkg-config", "--cflags", "eigen3"], capture_output=True, text=True)
        if not said.returncode:
            return said.stdout.split()
    raise SystemExit("Eigen 3 not found: set EIGEN to its folder of headers")


def compiled(sources, folder, dim, degree=2):
    """Path of the program in `dim` dimensions, for splines of a degree; sources: a checkout of matter.

    The compiler is `c++` or that of CXX.
    """
    place = Path(folder) / f"src{dim}{degree}"
    subprocess.run(["cp", "-r", str(Path(sources) / "src"), str(place)], check=True)
    tools = place / "tools.hpp"
    tools.write_text(re.sub(r"#define SPLINEDEG \d", f"#define SPLINEDEG {degree}", tools.read_text()))
    files = [file for file in sorted((place / "simulation").glob("*.cpp")) if file.name != "save_data.cpp"]
    program = Path(folder) / f"run{dim}{degree}"
    subprocess.run([os.environ.get("CXX", "c++"), "-std=c++17", "-O3", "-DNDEBUG", "-fopenmp", "-w",
                    *(["-DTHREEDIM"] if dim == 3 else []), f'-DSRC_DIR="{place}"', f'-DINCLUDE_DIR="{place}"',
                    f"-I{place}", *eigen(), str(Path(__file__).with_name("matter_run.cpp")), *map(str, files),
                    "-o", str(program)], check=True)
    return program


def run(program, problem, size, choice, time, x, v):
    """-> processor seconds of the steps, and position and velocity along x (n, 2) of all particles at `time`."""
    given = "\n".join(" ".join(f"{number:.17g}" for number in (*a, *b)) for a, b in zip(x, v, strict=True))
    ended = subprocess.run([str(program), problem, repr(float(size)), str(CHOICES[choice]), repr(float(time))],
                           input=given, capture_output=True, text=True, check=True)
    head, *found = ended.stdout[ended.stdout.index("FOUND"):].strip().split("\n")
    return float(head.split()[2]), np.array([[float(number) for number in line.split()] for line in found])

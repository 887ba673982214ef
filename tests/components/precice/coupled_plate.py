"""A block of snow against a plate: one that snowmpm computes itself, and the same one by preCICE.

Run as a program, `python -m` and this module, with FILE STEPS NUMBERS, it is the participant Solid of a configuration,
with so many steps in each window, and the plate of `docs/precice_wall.py` with these numbers (JSON). It prints what it
received, an impulse of two numbers [N s/m], and the displacement of its top along x [m].
"""

import json
import re
import runpy
import sys

from snowmpm import Simulation
from snowmpm.scenes.schema import Scene
from tests.support.project import ROOT

PROGRAM = runpy.run_path(str(ROOT / "docs" / "precice_wall.py"))
PLATE = {"foot": (0.513, -0.037), "top": (0.513, 0.583), "width": 0.2, "modulus": 2e6, "density": 900.0, "segments": 6,
         "damping": 0.3}
"""Ends of segments are no nodes of the grid: which of two takes a node would be left to round-off."""

SCHEME = """<coupling-scheme:{scheme}>
    <participants first="{first}" second="{second}" />
    <max-time value="{end}" />
    {window}
{rest}  </coupling-scheme:{scheme}>"""


def plate(**numbers):
    """`Wall` of the program in docs, with the numbers of the plate but for these."""
    return PROGRAM["Wall"](**PLATE | numbers)


def config(folder, end, scheme="serial-explicit", size=None, first="Snow"):
    """Write a configuration of preCICE into a folder, that of docs with another scheme, and velocities wherever it has
    displacements; -> its path. size [s]: of windows, None: the steps of the first participant."""
    text = (ROOT / "docs" / "precice_wall.xml").read_text()
    text = re.sub(r".*Displacement.*\n", lambda line: line[0] + line[0].replace("Displacement", "Velocity"), text)
    own, = re.findall(r"    <exchange.*\n(?=  </coupling-scheme)", text, re.DOTALL)
    if scheme.endswith("explicit"):
        own = "".join(re.findall(r".*<exchange.*\n", own))
    else:
        own = '    <max-iterations value="30" />\n' + own
    if scheme == "parallel-implicit":  # the force is sought as well
        own = re.sub(r".*<data name=.Velocity.*\n", lambda line: line[0] + line[0].replace("Velocity", "Force"), own)
    window = f'<time-window-size value="{size}" />' if size else '<time-window-size method="first-participant" />'
    own = SCHEME.format(scheme=scheme, end=end, window=window, first=first, rest=own,
                        second={"Snow": "Solid", "Solid": "Snow"}[first])
    path = folder / "precice-config.xml"
    path.write_text(re.sub(r"<coupling-scheme.*</coupling-scheme[^>]*>", own, text, flags=re.DOTALL).replace(
        'exchange-directory="."', f'exchange-directory="{folder}"'))
    return path


def scene(end_time, file=None, velocity=3.0, density=900.0, coupling="weak", names=None, **solver):
    """The scene in 2-D; file: configuration of preCICE, None: snowmpm bends the plate itself; names: other keys of its
    table; velocity [m/s]: of the snow."""
    body = {"name": "plate", "width": PLATE["width"], "segments": PLATE["segments"], "friction": 0.0}
    if file:
        body |= {"points": [PLATE["foot"], PLATE["top"]],
                 "precice": {"file": str(file), "velocity": "Velocity", **(names or {})}}
    else:
        body |= {"foot": PLATE["foot"], "top": PLATE["top"], "youngs_modulus": PLATE["modulus"], "density": density,
                 "damping": PLATE["damping"], "coupling": coupling}
    return Scene.model_validate({
        "name": "pressed", "dimension": 2, "end_time": end_time, "output": {"interval": end_time / 2},
        "solver": {"dx": 0.1, "precision": "f64", **solver},
        "domain": {"min": [-1.0, 0.0], "max": [3.0, 2.0], "boundary": {"z_min": "slip"}},
        "materials": {"snow": {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}},
        "bodies": [{"name": "snow", "material": "snow", "velocity": [velocity, 0.0],
                    "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.4, 0.4]}}],
        "structures": [body]})


def computed(scene):
    """A simulation at the end of its scene."""
    simulation = Simulation(scene)
    while simulation.time < scene.end_time:
        simulation.step(until=scene.end_time)
    return simulation


if __name__ == "__main__":
    other = plate(**json.loads(sys.argv[3]))
    PROGRAM["take_part"](other, sys.argv[1], int(sys.argv[2]), ("Displacement", "Velocity"))
    print(*map(float, (*other.received, other.rod.x[-1, 0] - other.start[-1, 0])))

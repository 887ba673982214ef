"""A block of snow against a plate: one that snowmpm computes itself, and the same one by preCICE."""

import numpy as np

from snowmpm.scenes.schema import Scene
from snowmpm.structures.rod import Rod
from snowmpm.structures.section import Section

FOOT, TOP, WIDTH, SEGMENTS = (0.513, -0.037), (0.513, 0.583), 0.2, 6
"""Ends of segments are no nodes of the grid: which of two takes a node would be left to round-off."""
MODULUS, DAMPING = 2e6, 0.3

CONFIG = """<?xml version="1.0"?>
<precice-configuration>
  <log><sink filter="%Severity% >= warning" /></log>
  <profiling mode="off" />
  <data:vector name="Force" waveform-degree="{degree}" />
  <data:vector name="Displacement" />
  <data:vector name="Velocity" />
  <mesh name="Snow-Mesh" dimensions="{dim}">
    <use-data name="Force" /> <use-data name="Displacement" /> <use-data name="Velocity" />
  </mesh>
  <mesh name="Solid-Mesh" dimensions="{dim}">
    <use-data name="Force" /> <use-data name="Displacement" /> <use-data name="Velocity" />
  </mesh>
  <participant name="Snow">
    <provide-mesh name="Snow-Mesh" />
    <receive-mesh name="Solid-Mesh" from="Solid" />
    <write-data name="Force" mesh="Snow-Mesh" />
    <read-data name="Displacement" mesh="Snow-Mesh" />
    <read-data name="Velocity" mesh="Snow-Mesh" />
    <mapping:nearest-neighbor direction="write" from="Snow-Mesh" to="Solid-Mesh" constraint="conservative" />
    <mapping:nearest-neighbor direction="read" from="Solid-Mesh" to="Snow-Mesh" constraint="consistent" />
  </participant>
  <participant name="Solid">
    <provide-mesh name="Solid-Mesh" />
    <read-data name="Force" mesh="Solid-Mesh" />
    <write-data name="Displacement" mesh="Solid-Mesh" />
    <write-data name="Velocity" mesh="Solid-Mesh" />
  </participant>
  <m2n:sockets acceptor="Snow" connector="Solid" exchange-directory="{folder}" />
  <coupling-scheme:{scheme}>
    <participants first="{first}" second="{second}" />
    <max-time value="{end}" />
    {window}
    <exchange data="Force" mesh="Solid-Mesh" from="Snow" to="Solid" substeps="false" />
    <exchange data="Displacement" mesh="Solid-Mesh" from="Solid" to="Snow" substeps="false" />
    <exchange data="Velocity" mesh="Solid-Mesh" from="Solid" to="Snow" substeps="false" />
    {rounds}
  </coupling-scheme:{scheme}>
</precice-configuration>
"""

ROUNDS = """<max-iterations value="30" />
    <relative-convergence-measure limit="1e-8" data="Displacement" mesh="Solid-Mesh" />
    <relative-convergence-measure limit="1e-8" data="Velocity" mesh="Solid-Mesh" />
    <acceleration:IQN-ILS>
      <data name="Displacement" mesh="Solid-Mesh" />
      <data name="Velocity" mesh="Solid-Mesh" />
      <initial-relaxation value="0.1" />
      <max-used-iterations value="60" />
      <time-windows-reused value="8" />
      <filter type="QR2" limit="1e-3" />
    </acceleration:IQN-ILS>"""


def config(folder, end, scheme="serial-explicit", size=None, first="Snow", degree=0, dim=2):
    """Write a configuration of preCICE into a folder; -> its path. size [s]: of windows, None: the snow's steps."""
    window = f'<time-window-size value="{size}" />' if size else '<time-window-size method="first-participant" />'
    path = folder / "precice-config.xml"
    path.write_text(CONFIG.format(scheme=scheme, end=end, window=window, first=first, folder=folder, degree=degree,
                                  second={"Snow": "Solid", "Solid": "Snow"}[first], dim=dim,
                                  rounds=ROUNDS if scheme.endswith("implicit") else ""))
    return path


def scene(end_time, file=None, velocity=3.0, density=900.0, coupling="weak", names=None, snow=300.0, **solver):
    """The scene in 2-D; file: configuration of preCICE, None: snowmpm bends the plate itself; names: of its data, and
    other keys of its table."""
    plate = {"name": "plate", "width": WIDTH, "friction": 0.0}
    if file:
        plate |= {"points": [FOOT, TOP], "segments": SEGMENTS,
                  "precice": {"file": str(file), "velocity": "Velocity", **(names or {})}}
    else:
        plate |= {"foot": FOOT, "top": TOP, "segments": SEGMENTS, "youngs_modulus": MODULUS, "density": density,
                  "damping": DAMPING, "coupling": coupling}
    return Scene.model_validate({
        "name": "pressed", "dimension": 2, "end_time": end_time, "output": {"interval": end_time / 2},
        "solver": {"dx": 0.1, "precision": "f64", **solver},
        "domain": {"min": [-1.0, 0.0], "max": [3.0, 2.0], "boundary": {"z_min": "slip"}},
        "materials": {"snow": {"kind": "elastic", "density": snow, "youngs_modulus": 1e5, "poisson_ratio": 0.2}},
        "bodies": [{"name": "snow", "material": "snow", "velocity": [velocity, 0.0],
                    "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.4, 0.4]}}],
        "structures": [plate]})


class Plate:
    """The plate in another program: snowmpm's own rod with its weight, by forces and displacements in the plane."""

    def __init__(self, density=900.0):
        self.rod = Rod((FOOT[0], 0.0, FOOT[1]), (TOP[0], 0.0, TOP[1]), SEGMENTS,
                       Section.plate(WIDTH, MODULUS, density), DAMPING)
        self.start = self.rod.x.copy()
        self.received = np.zeros(2)

    def window(self, dt, force):
        """Displacement and velocity (n, 2) after dt [s] under forces (n, 2) [N/m]."""
        forces = self.rod.masses[:, None] * np.array([0.0, 0.0, -9.81])
        forces[:, [0, 2]] += force
        self.rod.advance(dt, forces)
        self.received = self.received + dt * force.sum(axis=0)
        return (self.rod.x - self.start)[:, [0, 2]], self.rod.v[:, [0, 2]].copy()

    def state(self):
        """All that a window begins with."""
        return self.rod.state(), self.received

    def restore(self, state):
        """Take it over."""
        self.rod.restore(state[0])
        self.received = state[1]

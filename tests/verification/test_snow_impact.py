"""Snow runs into a wall (S7): early pressure of the plastic wave, and the momentum that the wall takes.

A block of light snow, held at its sides, hits a rigid wall at V. Until the wave has run through it, the wall bears the
pressure behind a plastic compaction wave of the piston problem (M10), seen from the other side:

    P = P_y + rho0 D V = 11.0 kPa for V = 4.3 m/s, rho0 = 200 kg/m3 (D = 9.47 m/s)

and in the end the impulse is what the block lost, m V and a little more, for it springs back at a few per cent of V.
"""

import numpy as np
import pytest
import trimesh

from snowmpm.io import Obstacle, Run, RunWriter
from snowmpm.io.impact import impacts, loaded
from snowmpm.io.wetted import Face
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.quantities.table import QUANTITIES
from snowmpm.scenes.cards import material_card
from snowmpm.study.problems.rigid_walls import block
from snowmpm.study.problems.schemes import APIC, lattice

DX, WIDTH, SPEED = 0.02, 0.08, 4.3
PRESSURE, ELASTIC_WAVE = 11005.0, 142.0


def impulse_on_a_wall(length, end):
    """A block of this length [m] hits a wall: times [s], impulse on the wall [N s/m], and the solver."""
    law = material_card("li_vallee_de_la_sionne")
    positions, volumes = lattice([-length, 0.0], [0.0, WIDTH], DX)
    wall = block([0.0, WIDTH / 2], [-1.0, 0.0], 2.0, "separate")
    lower, upper = np.array([-2.0 * length, 0.0]), np.array([0.2, WIDTH])
    solver = MpmSolver(Population(positions, volumes, 0, np.broadcast_to([SPEED, 0.0], positions.shape).copy()), [law],
                       dx=DX, precision="f64", origin=lower, lower=lower, upper=upper, gravity=np.zeros(2),
                       sides=[["open", "open"], ["slip", "slip"]], obstacles=[wall], **APIC.options)
    rows = [(0.0, 0.0)]
    while solver.time < end:
        for _ in range(10):
            solver.step(solver.stable_dt()[0])
        rows.append((solver.time, solver.obstacle_totals[0, 0]))
    return *np.array(rows).T, solver


def test_early_pressure():
    """Until the elastic wave is back from the free end: from then on the snow that is not yet crushed slows down."""
    length = 4.0
    end = 1.9 * length / ELASTIC_WAVE
    time, impulse, _ = impulse_on_a_wall(length, end)
    early = time > 0.3 * end
    # 5 %: what rings behind the front of a strong wave in fresh snow leaves the stress 4 % low (test_plastic_wave)
    assert np.polyfit(time[early], impulse[early], 1)[0] / WIDTH == pytest.approx(PRESSURE, rel=0.05)


def test_the_wall_takes_the_momentum():
    time, impulse, solver = impulse_on_a_wall(0.4, 0.14)
    momentum = solver.particles.mass * SPEED
    left = solver.particles.masses() @ solver.particles.column("velocity")[:, 0]
    assert impulse[-1] == pytest.approx(momentum - left, rel=1e-9)
    assert -0.15 * momentum < left <= 0.0  # it springs back a little, then lets go
    assert impulse[-1] == pytest.approx(np.interp(0.12, time, impulse), rel=1e-3)


def record(time, force, direction=(1.0, 0.0, 0.0)):
    """An obstacle 0.5 m by 2 m, standing up along z, seen along x, with this force (rows,) over time."""
    corners = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.3, 0.0, 2.0], [0.0, 0.0, 2.0]])
    ring = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
    loads = force[:, None] * np.array(direction)
    impulse = np.cumsum(loads * np.diff(time, prepend=0.0)[:, None], axis=0)
    zero = np.zeros(len(time))
    return Obstacle(corners, ring, np.eye(3)[None], np.zeros((1, 3)), time, loads, zero, impulse, zero)


def test_peak_and_steady_part():
    """A peak of 5 kN/m for 0.1 s, then 2 kN/m for 3.9 s."""
    time = np.arange(1, 801) * 0.01
    force = np.select([time <= 1.0, time <= 1.1, time <= 5.0], [0.0, 5e3, 2e3], 0.0)
    found = loaded(record(time, force))
    assert found.impulse == pytest.approx(5e3 * 0.1 + 2e3 * 3.9)
    assert found.peak == pytest.approx(5e3, rel=1e-9) and 1.0 <= found.peak_time <= 1.1
    assert found.steady == pytest.approx(2e3, rel=1e-9) and found.arrival == pytest.approx(1.0, abs=0.03)
    assert loaded(record(time, 0.0 * force)) is None


def test_pressure_is_over_the_part_of_the_face_that_snow_touches(tmp_path):
    """20 kN on a mast 10 m high and 1 m wide, on which snow stands 1 m: 20 kPa, not 2; snow behind it counts not."""
    mast = trimesh.creation.box(extents=[1.0, 1.0, 10.0])
    mast.apply_translation([5.0, 0.0, 5.0])
    axes = [np.arange(4.05, 4.5, 0.1), np.arange(-0.95, 1.0, 0.1), np.arange(0.05, 1.0, 0.1)]
    snow = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    behind = [5.55, 0.0, 8.0]
    with RunWriter(tmp_path, provenance={"scene_name": "mast", "particle_spacing": 0.1},
                   obstacles={"mast": (mast.vertices, mast.faces), "beside": (mast.vertices, mast.faces)}) as writer:
        for time in np.arange(0.0, 3.01, 0.5):
            touching = snow if time > 0.9 else snow - [3.0, 0.0, 0.0]
            rows = time - 0.5 + np.arange(1, 51) * 0.01
            force = np.outer(np.where(rows > 1.0, 2e4, 0.0), [1.0, 0.0, 0.0])
            impulse = np.outer(2e4 * np.maximum(rows - 1.0, 0.0), [1.0, 0.0, 0.0])
            load = {"time": rows, "force": force, "impulse": impulse, "moment": 0.0 * force, "work": 0.0 * rows}
            loads = {"mast": load, "beside": {**load, "impulse": 0.0 * impulse}} if time else {}
            writer.frame(time, np.vstack([touching, behind]), {}, loads=loads)
    found, = impacts(Run(tmp_path)).values()
    numbers = found.numbers
    assert numbers["face_area"] == pytest.approx(10.0) and numbers["wetted_area"] == pytest.approx(1.0, rel=0.06)
    assert numbers["impact_peak_force"] == pytest.approx(2e4, rel=1e-6)
    assert numbers["impact_peak_pressure"] == pytest.approx(2e4, rel=0.06)
    assert numbers["impact_steady_pressure"] == pytest.approx(2e4, rel=0.06)
    assert found.texts()["impact_peak_force"].endswith(" kN") and set(numbers) <= set(QUANTITIES)


def test_face_seen_along_a_direction():
    """Of a box 1 by 2 by 3, and of a section: its area in pieces, however its facets are oriented."""
    box = trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
    for facets in (box.faces, box.faces[:, ::-1]):
        for direction, area in (([1.0, 0.0, 0.0], 6.0), ([0.0, 1.0, 0.0], 3.0), ([0.0, 0.0, -1.0], 2.0)):
            face = Face(box.vertices, facets, np.array(direction), 0.2)
            assert face.area == face.areas.sum() == pytest.approx(area)
            assert np.allclose(face.centres @ direction, min(box.vertices @ direction))
    ring = record(np.ones(1), np.ones(1))
    face = Face(ring.vertices, ring.facets, np.array([1.0, 0.0, 0.0]), 0.1)
    assert face.area == pytest.approx(2.0) and np.allclose(face.centres[:, 0], 0.0) and len(face.areas) >= 40

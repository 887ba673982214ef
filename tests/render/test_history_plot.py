"""The plot of a run's history: every quantity that is there, in its panel, with its numbers."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter
from snowmpm.render import render_history
from snowmpm.render.history_plot import history_figure

TIMES = np.linspace(0.0, 2.0, 21)
SNOW = np.column_stack([np.full(10, 4.95), np.linspace(0.05, 0.95, 10)])
"""What touches the wall, 3 m high, from its foot to a metre above it [m]."""


def impact(t):
    """Force (2,) [N/m] of made-up snow that hits a wall at 0.5 s."""
    rise = np.clip((t - 0.5) / 0.2, 0.0, 1.0)
    return np.array([4.0e4 * rise * np.exp(-np.maximum(t - 0.7, 0.0)) + 3e3 * np.sin(300.0 * t) * rise, -9.0e3 * rise])


def write(path, dimension=2, obstacles=True, counts=True, frames=None):
    """A run that slides, hits a wall and stops; loads in 50 rows a frame, and their exact sums by name."""
    corners = np.array([[5.0, 0.0], [6.0, 0.0], [6.0, 3.0], [5.0, 3.0]])
    drawings = {"wall": (corners, np.array([[0, 1], [1, 2], [2, 3], [3, 0]]))} if dimension == 2 else {
        "wall": (np.eye(3), np.array([[0, 1, 2]]))}
    total = np.zeros(2)
    steps = dict.fromkeys(("elastic", "advective", "output"), 0)
    with RunWriter(path, provenance={"scene_name": "made_up_impact", "particle_spacing": 0.1},
                   dimension=dimension, obstacles=drawings if obstacles else None) as writer:
        for i, t in enumerate(TIMES[:frames]):
            rows = {}
            if i and obstacles:
                ends = np.linspace(TIMES[i - 1], t, 51)[1:]
                force = impact(ends).T
                impulse = total + np.cumsum(force, axis=0) * (ends[1] - ends[0])
                total = impulse[-1]
                if dimension == 3:
                    force, impulse = (np.insert(values, 1, 0.0, axis=1) for values in (force, impulse))
                turning = force[:, 0] * 1.5 if dimension == 2 else force * 1.5
                rows = {"wall": {"time": ends, "force": force, "moment": turning, "impulse": impulse,
                                 "work": np.zeros(50)}}
            steps["advective" if t > 1.0 else "elastic"] += 99 * (i > 0)
            steps["output"] += i > 0
            row = {"front": 3.0 * t, "front_distance": 4.0 * t, "max_speed": 5.0 * np.exp(-t), "dt": 1e-3,
                   "kinetic_energy": 1e5 * np.exp(-2 * t), "elastic_energy": 1e3 * t, "potential_energy": -5e4 * t,
                   "plastic_work": 6e4 * t, "contact_work": 3e4 * t, "energy_remainder": 1e2 * t,
                   "steps": float(sum(steps.values()))}
            row |= {f"steps_{cause}": n for cause, n in steps.items()} if counts else {}
            writer.history(t, row, {})
            snow = SNOW if dimension == 2 and t >= 0.45 else np.zeros((1, dimension))
            writer.frame(t, snow, {}, loads=rows)
    return Run(path)


def panel(figure, title):
    return next(axes for axes in figure.axes if axes.get_title(loc="left").startswith(title))


def lines(axes):
    return {line.get_label(): line.get_ydata() for line in axes.get_lines()}


def stairs(axes):
    """(values, edges) of the steps by label; the unlabelled ones are the fine record."""
    named = {}
    for patch in axes.patches:
        named.setdefault(patch.get_label(), []).append(patch.get_data())
    return named


def test_every_quantity_is_in_its_panel(tmp_path):
    run = write(tmp_path)
    figure = history_figure(run)
    assert [axes.get_title(loc="left") for axes in figure.axes if axes.get_visible()] == [
        "front", "speed of the fastest particle", "energy", "time step and what limits it",
        "pressure where snow touches the obstacle", "force on wall",
        "moment on wall, about its centre of rotation"]
    assert np.array_equal(lines(panel(figure, "front"))["from the top of what moved"],
                          run.history["front_distance"])
    energies = lines(panel(figure, "energy"))
    assert panel(figure, "energy").get_ylabel() == "[kJ/m]"
    assert energies["potential, lost"] == pytest.approx(50.0 * TIMES)
    assert "left with snow" not in energies
    assert energies["kinetic"] == pytest.approx(100.0 * np.exp(-2 * TIMES)) and len(energies) == 6


def test_pressure_is_the_force_over_what_snow_touches(tmp_path):
    """Snow stands a metre high at a wall of 3 m; per metre of width."""
    figure = history_figure(write(tmp_path))
    (label, ((values, edges, _), *_)), = stairs(panel(figure, "pressure")).items()
    force, = (values for values, _, _ in stairs(panel(figure, "force on wall"))["x"])
    assert panel(figure, "pressure").get_ylabel() == "[kPa]" and panel(figure, "force on wall").get_ylabel() == "[kN/m]"
    assert label.startswith("wall: ") and "at peak force" in label and np.array_equal(edges, TIMES)
    assert values[5:] == pytest.approx(force[5:], rel=0.06) and (values[:4] == 0.0).all()


def test_the_step_has_the_colour_of_its_cause(tmp_path):
    steps = stairs(panel(history_figure(write(tmp_path)), "time step"))
    assert steps.keys() == {"elastic", "advective"}  # the last step before a frame never limits most of them
    for cause, there in (("elastic", TIMES[1:] <= 1.0), ("advective", TIMES[1:] > 1.0)):
        (values, edges, _), = steps[cause]
        assert np.array_equal(edges, TIMES) and np.array_equal(np.isfinite(values), there)
        assert values[there] == pytest.approx(1e-3)
    plain = stairs(panel(history_figure(write(tmp_path / "plain", counts=False)), "time step"))
    assert [len(found) for found in plain.values()] == [1]


@pytest.mark.parametrize("dimension", [2, 3])
def test_loads_are_means_between_frames_over_the_fine_record(tmp_path, dimension):
    run = write(tmp_path, dimension)
    figure, wall = history_figure(run), run.obstacles["wall"]
    force, moment = stairs(panel(figure, "force on wall")), stairs(panel(figure, "moment on wall"))
    axes = "xz" if dimension == 2 else "xyz"
    assert set(axes) <= force.keys()
    for axis in axes:
        (values, edges, _), = force[axis]
        assert np.allclose(edges, TIMES)
        wanted = wall.force[:, "xyz".index(axis)].reshape(20, 50).mean(axis=1) / 1e3
        assert values == pytest.approx(wanted, abs=1e-9)
    fine = max((data for label, found in force.items() for data in found if label not in set(axes)),
               key=lambda data: np.abs(data[0]).max())
    assert fine[0] == pytest.approx(wall.force[:, 0] / 1e3) and len(fine[0]) == 1000
    (values, _, _), = moment["from x to z" if dimension == 2 else "x"]
    turning = wall.moment if dimension == 2 else wall.moment[:, 0]
    assert values == pytest.approx(turning.reshape(20, 50).mean(axis=1) / 1e3)
    unit = "/m]" if dimension == 2 else "]"
    assert panel(figure, "force").get_ylabel() == "[kN" + unit
    assert panel(figure, "moment").get_ylabel() == "[kN m" + unit


@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg"])
def test_it_becomes_a_file(tmp_path, ending):
    write(tmp_path)
    path = render_history(tmp_path, tmp_path / "new" / f"history{ending}", dpi=50)
    assert path.stat().st_size > 5000 and [entry.name for entry in path.parent.iterdir()] == [path.name]


def test_what_cannot_be_drawn_is_refused(tmp_path):
    write(tmp_path, frames=1)
    with pytest.raises(InputError, match="no history to plot yet"):
        render_history(tmp_path, tmp_path / "history.png")
    with pytest.raises(InputError, match=r"must end in \.png"):
        render_history(tmp_path, tmp_path / "history.doc")
    write(tmp_path, frames=2, obstacles=False)
    assert render_history(tmp_path, tmp_path / "history.png", dpi=50).is_file()

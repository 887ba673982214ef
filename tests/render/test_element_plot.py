"""The plot of an element test, from plain arrays."""

import warnings
from dataclasses import replace

import imageio.v2 as imageio
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from snowmpm.errors import InputError
from snowmpm.render import ElementCurves, render_element
from snowmpm.render.element_plot import PATH, SECOND, SURFACE, element_figure

STRAIN = np.linspace(0.0, 0.2, 50)
Q = 2e4 * (1.0 - np.exp(-40.0 * STRAIN))
P_GRID, Q_GRID = np.linspace(-1e4, 5e4, 61), np.linspace(0.0, 3e4, 61)


def ellipse(size):
    p, q = np.meshgrid(P_GRID, Q_GRID)
    return q**2 + p * (p - size)


CURVES = ElementCurves(
    title="triaxial: snow",
    strain_label="axial shortening [-]",
    strain=STRAIN,
    p=1e4 + Q / 3.0,
    q=Q,
    volumetric=-0.05 * STRAIN,
    plastic=-0.04 * STRAIN,
    hardening=("p0", "Pa", 3e4 + 1e4 * STRAIN),
    yield_row=5,
    peak_row=30,
    section=("yield surface", P_GRID, Q_GRID, ellipse(3e4), ellipse(4e4)),
)


def share(picture, colour):
    """Share of the pixels that have this colour, up to the blending of thin lines."""
    return (np.abs(picture - 255.0 * np.array(to_rgb(colour))).max(axis=-1) < 30.0).mean()


def draw(curves, folder, name="plot.png"):
    # A message of Matplotlib's, of an empty contour or a range of no width, is a fault too
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        path = render_element(curves, folder / "new" / name, dpi=70)
    assert [entry.name for entry in path.parent.iterdir()] == [name]
    return imageio.imread(path)[..., :3].astype(float) if name.endswith(".png") else path.read_bytes()


def test_every_curve_is_drawn(tmp_path):
    picture = draw(CURVES, tmp_path)
    everything = {colour: share(picture, colour) for colour in (PATH, SECOND, SURFACE)}
    assert min(everything.values()) > 2e-4  # lines of one or two pixels in 400 000
    without = draw(replace(CURVES, section=None), tmp_path / "none")
    # What is left of the grey is the blending of letters; the two surfaces are 1.7e-3 of all pixels
    assert everything[SURFACE] - share(without, SURFACE) > 1e-3


def test_panels_show_what_their_labels_say():
    path, stress, volume, state = element_figure(CURVES).axes

    def line(axes, name):
        return next(line for line in axes.lines if line.get_label() == name).get_xydata().T

    for axes, name, x, y in [
        (path, "path", CURVES.p / 1e3, CURVES.q / 1e3),
        (stress, "q", STRAIN, CURVES.q / 1e3),
        (stress, "p", STRAIN, CURVES.p / 1e3),
        (volume, "total", STRAIN, CURVES.volumetric),
        (volume, "plastic", STRAIN, CURVES.plastic),
        (state, "_child0", STRAIN, CURVES.hardening[2] / 1e3),
    ]:
        np.testing.assert_array_equal(line(axes, name), [x, y])
    for name, row in (("start", 0), ("yield", 5), ("peak", 30), ("end", 49)):
        np.testing.assert_array_equal(line(path, name)[:, 0], [CURVES.p[row] / 1e3, CURVES.q[row] / 1e3])
    units = [axes.get_xlabel() + axes.get_ylabel() for axes in (path, stress, volume, state)]
    assert all("kPa" in text for text in (units[0], units[1], units[3])) and "[-]" in units[2]


def test_surfaces_that_are_the_same_are_one(tmp_path):
    section = (*CURVES.section[:4], ellipse(3e4))
    text = draw(replace(CURVES, section=section), tmp_path, "plot.svg")
    both = draw(CURVES, tmp_path / "two", "plot.svg")
    # Text is drawn as outlines, and named in a comment
    assert b"initial yield surface" in both and b"final yield surface" in both
    assert b"initial yield surface" not in text and b"yield surface" in text


@pytest.mark.parametrize(
    "changes",
    [
        {"q": np.zeros(50), "p": np.linspace(-1.0, 1.0, 50)},
        {"p": np.zeros(50), "q": np.zeros(50), "peak_row": None, "yield_row": None},
        {"volumetric": np.full(50, 1e-17), "plastic": None},
        {"hardening": None, "plastic": np.zeros(50)},
        {"hardening": ("damage", "-", np.ones(50))},
        {"section": (*CURVES.section[:3], ellipse(3e4), np.meshgrid(P_GRID, Q_GRID)[0] ** 2 + 1.0)},
        {"section": (*CURVES.section[:3], np.full((61, 61), -np.inf), np.full((61, 61), -np.inf))},
    ],
    ids=["no shear", "nothing", "no volume", "no state", "damage", "separated", "never yields"],
)
def test_what_can_be_missing(tmp_path, changes):
    assert draw(replace(CURVES, **changes), tmp_path).std() > 5.0


def test_another_ending_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"must end in \.png, \.pdf or \.svg"):
        render_element(CURVES, tmp_path / "plot.doc")
    assert not list(tmp_path.iterdir())

"""U6: bonds bend and break as beams, a sheared cell, jumps of a weak layer, and the law that is made from them."""

import json

import numpy as np
import pytest
import tomllib

from snowmpm.cli.grains import grains as grains_command
from snowmpm.errors import InputError
from snowmpm.materials import AnticrackCamClay
from snowmpm.micro.grains.assembly import Assembly
from snowmpm.micro.grains.bonded import bonded_cell
from snowmpm.micro.grains.contact import ContactLaw
from snowmpm.micro.grains.curves import DrivenCurve, jump_path
from snowmpm.micro.grains.fitting import difference, fitted_law, predictions
from snowmpm.micro.grains.pairs import Pairs

K = 1e5
SNOW = ContactLaw(5e3, 2.5e3, friction=0.2, strength=1.7e4, shear_strength=1.7e4)


@pytest.fixture(scope="module")
def sample():
    return bonded_cell(60, 5e-4, SNOW, solid=0.4, density=290.0)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_bond_bends_until_its_edge_breaks(share):
    """A weight beside the bond bends it by its lever, the radius: 4 M / (A r) = 4 F / A at the edge."""
    strength = 1e3
    pair = Assembly([[0.0, 0.0, 0.0], [2.0 - 1e-6, 0.0, 0.0]], [1.0, 1.0],
                    ContactLaw(K, K, damping=0.5, strength=strength, shear_strength=1e9), density=10.0, damping=100.0,
                    fixed=[1, 0])
    assert pair.bond(relaxed=True) == 1
    pair._pull = np.array([0.0, 0.0, -share * 0.25 * np.pi * strength / pair.mass[1]])
    pair.step(6000)
    assert (pair.bonds == 1) == (share < 1.0)
    if share < 1.0:  # sinks by what bends and by what slides: F r^2 / (K r^2 / 4) + F / K
        force = share * 0.25 * np.pi * strength
        assert -pair.positions[1, 2] == pytest.approx(5.0 * force / K, rel=0.02)


def test_pairs_of_a_cell_that_is_sheared():
    rng = np.random.default_rng(3)
    positions, radii = rng.uniform(-3.0, 5.0, (50, 3)), rng.uniform(0.2, 0.4, 50)
    box, slide = np.array([3.0, 3.5, 4.0]), np.array([1.3, -0.7])
    found = Pairs.near(positions, radii, 0.1, box, slide)
    base = np.array([[box[0], 0.0, 0.0], [0.0, box[1], 0.0], [*slide, box[2]]])
    images = np.stack(np.meshgrid(*[np.arange(-4, 5)] * 3, indexing="ij"), -1).reshape(-1, 3) @ base
    way = (positions[:, None] - positions[None])[:, :, None] + images
    gap = np.linalg.norm(way, axis=3).min(axis=2) - radii[:, None] - radii[None]
    assert np.array_equal(np.argwhere(np.triu(gap < 0.1, 1)), np.stack([found.first, found.second], 1))


def test_a_sample_is_bonded_and_free_of_stress(sample):
    assert 1.0 / (1.0 + sample.void_ratio) == pytest.approx(0.4, rel=2e-3)
    assert 2.0 * sample.bonds / 60 > 2.4 and np.abs(sample.stress()).max() < 1e-3


def test_a_jump_loads_and_unloads_before_bonds_break(sample):
    """F = I + u x N / h, and a traction that goes back the way it came."""
    curve = jump_path(sample, [(-1e-3, 1e-3), (-2e-4, 2e-4)], "jump")
    np.testing.assert_allclose(curve.jump[-1], [2e-4, 0.0, -2e-4], rtol=1e-6, atol=1e-15)
    assert curve.bonds.min() == 1.0
    farthest = int(np.argmin(curve.jump[:, 2]))
    for share in (0.4, 0.7):
        loading, unloading = (np.array([np.interp(share * 1e-3, way, part[:, k]) for k in (0, 2)]) for way, part in (
            (-curve.jump[: farthest + 1, 2], curve.traction[: farthest + 1]),
            (-curve.jump[farthest:, 2][::-1], curve.traction[farthest:][::-1])))
        np.testing.assert_allclose(loading, unloading, atol=0.05 * np.abs(curve.traction).max())
    assert (curve.traction[farthest, [0, 2]] * [1.0, -1.0] > 0.0).all()
    np.testing.assert_allclose(curve.traction, curve.stress[:, :, 2], rtol=1e-9)


def made_by(law):
    """Curves that a law itself makes."""
    way = np.linspace(0.0, 1.0, 61)[:, None, None]
    one = np.zeros((3, 3))
    normal, shear = one.copy(), one.copy()
    normal[2, 2] = shear[0, 2] = 1.0
    paths = {"closing": np.eye(3) - 0.1 * way**2 * normal, "shear": np.eye(3) + 0.02 * way * shear,
             "opening": np.eye(3) + 0.01 * way * normal, "all sides": np.eye(3) * (1.0 - 0.01 * way),
             "both": np.eye(3) + 0.015 * way * (shear - normal)}
    curves = [DrivenCurve(name, F, np.zeros_like(F), np.ones(len(F))) for name, F in paths.items()]
    firm = law.model_copy(update={"p0": 1e9})
    made = []
    for curve, stress, elastic in zip(curves, predictions(law, curves), predictions(firm, curves), strict=True):
        whole = np.abs(stress - elastic).max(axis=(1, 2)) < 1e-6 * np.abs(stress).max()
        yielding = np.arange(61) < 3 + int(whole.sum())
        bonds = np.where(whole, 1.0, np.where(yielding, 0.95, 0.5))
        made.append(DrivenCurve(curve.name, curve.deformation, stress, bonds))
    return made


def test_the_fit_finds_the_law_that_made_the_curves():
    law = AnticrackCamClay(density=100.0, youngs_modulus=5e5, poisson_ratio=0.2, critical_slope=1.1, cohesion=0.3,
                           p0=2e3, hardening=0.05, softening=30.0)
    found = fitted_law(made_by(law), density=100.0)
    for name in ("youngs_modulus", "poisson_ratio", "critical_slope", "cohesion", "p0", "hardening", "softening"):
        assert getattr(found.law, name) == pytest.approx(getattr(law, name), rel=0.02), name
    assert max(found.errors.values()) < 0.01
    assert all(low <= high for low, high in found.intervals.values())


@pytest.mark.parametrize("key, value, said", [("solid", 0.05, "--solid"), ("friction", -1.0, "--friction"),
                                              ("name", "a/b", "NAME")])
def test_bad_numbers_are_refused(key, value, said):
    with pytest.raises(InputError, match=said):
        grains_command(**{key: value})


@pytest.mark.slow
def test_a_card_of_a_bonded_sample(tmp_path, capsys):
    """U6: the law reproduces the oedometer of the grains, normal stress, to 10 % of its largest (root mean square)."""
    from snowmpm.scenes import load_scene

    grains_command(name="mine", output=tmp_path, quiet=True)
    record = json.loads((tmp_path / "grains.json").read_text())
    card = tomllib.loads((tmp_path / "mine.toml").read_text())
    assert "200 bonded grains" in card["description"] and "95 % intervals" in card["validity"]
    table = np.genfromtxt(tmp_path / "curves.csv", delimiter=",", names=True, dtype=None, encoding=None)
    closing = table[table["test"] == "closing"]
    way = np.abs(np.gradient(closing["F_zz"]))
    grains, law = closing["stress_zz_Pa"], closing["law_zz_Pa"]
    assert np.sqrt(((grains - law) ** 2 * way).sum() / way.sum()) < 0.1 * np.abs(grains).max()
    for name, (low, high) in record["intervals"].items():
        assert low <= card["material"][name] <= high
    scene = load_scene("pst_2d", {"materials.weak_layer": {"card": str(tmp_path / "mine.toml")}})
    assert scene.materials["weak_layer"].p0 == card["material"]["p0"]


def test_difference_is_over_the_largest_stress():
    F = np.tile(np.eye(3), (5, 1, 1))
    F[:, 2, 2] = np.linspace(1.0, 0.9, 5)
    stress = np.zeros((5, 3, 3))
    stress[:, 2, 2] = -np.arange(5.0)
    assert difference(DrivenCurve("closing", F, stress, np.ones(5)), 1.1 * stress) == pytest.approx(
        0.1 * np.sqrt(np.average(np.arange(5.0) ** 2, weights=[0.5, 1, 1, 1, 0.5])) / 4.0, rel=0.2)

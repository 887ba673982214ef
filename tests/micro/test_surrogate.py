"""What is learnt from driven cells: the process itself, permeability of sheared cells, paths that were not learnt."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.optimize import check_grad

from snowmpm.micro.gaussian_process import GaussianProcess
from snowmpm.micro.grains.assembly import Assembly
from snowmpm.micro.grains.bonded import bonded_cell, scattered
from snowmpm.micro.grains.contact import ContactLaw
from snowmpm.micro.grains.pore_space import cell_permeability, voxels
from snowmpm.micro.grains.surrogate import LearntPath, Surrogate, learnt_path, random_jumps, unseen_errors
from snowmpm.micro.permeability import permeability

SNOW = ContactLaw(8e3, 4e3, friction=0.2, strength=2.72e4, shear_strength=2.72e4)


def test_a_process_finds_a_surface_and_its_noise():
    """And says what it does not know: the intervals of 95 % hold 94 % of new values, as the mean of 12 draws."""
    def surface(at):
        return 30.0 + 5.0 * np.sin(6.0 * at[:, 0]) * at[:, 1]

    inside = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        x, z = rng.random((150, 2)), rng.random((400, 2))
        process = GaussianProcess(x, surface(x) + 0.2 * rng.standard_normal(150))
        found, spread = process(z)
        assert process.noise == pytest.approx(0.2, rel=0.2) and np.sqrt(((found - surface(z)) ** 2).mean()) < 0.1
        inside.append((np.abs(found - surface(z) - 0.2 * rng.standard_normal(400)) < 1.96 * spread).mean())
    assert 0.90 < np.mean(inside) < 0.99
    far, unsure = process(np.array([[100.0, 100.0]]))
    assert far[0] == pytest.approx(process._mean, abs=1e-6) and unsure[0] > 3.0 * spread.max()
    start = np.log([0.3, 0.8, 1.2, 0.1])
    slope = process._unlikelihood(start)[1]
    assert check_grad(lambda of: process._unlikelihood(of)[0], lambda of: process._unlikelihood(of)[1], start) < (
        1e-4 * np.linalg.norm(slope))


def test_a_process_refuses_what_is_no_number():
    for x, y in (([[0.0]], [1.0]), ([[0.0], [np.nan]], [1.0, 2.0])):
        with pytest.raises(ValueError, match="finite numbers"):
            GaussianProcess(x, y)


def lifted(image, levels, slide):
    """The same periodic image, cut so many voxels lower."""
    below = np.roll(image[:, :, -levels:], [-shift for shift in slide], axis=(0, 1))
    return np.concatenate([below, image[:, :, :-levels]], axis=2)


def test_the_image_above_slides():
    """The permeability of a sheared cell does not depend on where it is cut; without the slide it would."""
    rng = np.random.default_rng(4)
    field = ndimage.gaussian_filter(rng.standard_normal((14, 12, 10)), 2.0, mode="wrap")
    pores, slide = field < 0.3 * field.std(), (5, -3)
    whole = permeability(pores, 1.0, (0, 2), precision="f64", slide=slide)
    again = permeability(lifted(pores, 4, slide), 1.0, (0, 2), precision="f64", slide=slide)
    np.testing.assert_allclose(np.diag(again.tensor)[[0, 2]], np.diag(whole.tensor)[[0, 2]], rtol=1e-3)
    other = permeability(lifted(pores, 4, slide), 1.0, (0, 2), precision="f64")
    assert abs(other.tensor[2, 2] / whole.tensor[2, 2] - 1.0) > 0.03


def test_voxels_of_a_sheared_cell():
    rng = np.random.default_rng(5)
    radii = rng.uniform(0.8, 1.2, 30)
    positions, box = scattered(radii, 0.1, rng)
    cell = Assembly(positions, radii, ContactLaw(1e5, 5e4), box=box)
    cell.slide[:] = np.array([7, -4]) * box[0] / 40
    pores, side, slide = voxels(cell, 40)
    assert pores.shape == (40, 40, 40) and slide.tolist() == [7, -4]
    assert 1.0 - pores.mean() == pytest.approx((4.0 / 3.0 * np.pi * radii**3).sum() / box.prod(), rel=0.02)
    cell.positions[:, 2] += 9.0 * side
    assert np.array_equal(voxels(cell, 40)[0], lifted(pores, 9, slide))


def test_a_cubic_packing_of_grains_has_its_permeability():
    """6 % at 32 voxels a cell, as of images."""
    radius = (3.0 * 0.343 / (4.0 * np.pi)) ** (1.0 / 3.0)
    cell = Assembly([[0.9, 0.2, 0.4]], [radius], ContactLaw(1e5, 5e4), box=[1.0, 1.0, 1.0])
    np.testing.assert_allclose(cell_permeability(cell, 32), 0.04207 * radius**2, rtol=0.06)


def made_path(jumps, rng):
    """Of a layer that yields: elastic to where it was closest, with its strength falling on the way."""
    rows = np.concatenate([np.linspace(a, b, 60) for a, b in zip([np.zeros(2), *jumps[:-1]], jumps, strict=True)])
    closest = np.maximum.accumulate(np.maximum(-rows[:, 0], 0.0))
    traction = 1e3 * np.stack([np.tanh(20.0 * (rows[:, 0] + 0.7 * closest)), np.tanh(15.0 * rows[:, 1])], axis=1)
    at = np.array([60, 119, 179])
    pores = np.exp(5.0 * rows[at, :1] + np.array([-20.0, -19.5]) + 0.01 * rng.standard_normal((3, 2)))
    return LearntPath(rows, traction, at, pores)


def test_a_path_that_was_not_learnt():
    """Of a layer whose present the five numbers say in full, errors are small; outside of them it says so."""
    rng = np.random.default_rng(3)
    first = np.array([[-0.03, 0.0], [-0.1, 0.0], [-0.05, 0.0]])
    surrogate = Surrogate([made_path(jumps, rng) for jumps in (first, *random_jumps(8, 0.1, rng))])
    errors = [unseen_errors(surrogate, made_path(jumps, rng)) for jumps in random_jumps(4, 0.1, rng)]
    assert np.mean([one["traction"] for one in errors]) < 0.05 and max(one["permeability"] for one in errors) < 0.05
    assert np.mean([one["covered"] for one in errors]) > 0.8
    assert surrogate.knows([[0.0, 0.0], [-0.01, 0.0]]).all() and not surrogate.knows([[0.0, 0.0], [-0.9, 0.0]])[1]


def test_a_dry_surrogate_knows_no_permeability():
    path = made_path(np.array([[-0.03, 0.0], [-0.1, 0.01], [-0.05, 0.0]]), np.random.default_rng(1))
    dry = LearntPath(path.jump, path.traction, np.zeros(0, int), np.zeros((0, 2)))
    with pytest.raises(ValueError, match="without permeability"):
        Surrogate([dry]).permeability(path.jump)


def test_rows_with_permeability_are_those_of_the_path():
    """The pores of a layer that is closed get narrower."""
    sample = bonded_cell(40, 5e-4, SNOW, solid=0.38, seed=2, density=290.0)
    path = learnt_path(sample, [(-0.02, 0.0), (-0.1, 0.01)], voxels=20, looks=2)
    assert len(path.at) == len(path.permeability) == 3 and path.at[0] == 0
    assert (path.permeability[-1] < 0.95 * path.permeability[0]).all()
    np.testing.assert_allclose(path.jump[path.at[-1]], [-0.1, 0.01], rtol=2e-3)

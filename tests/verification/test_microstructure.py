"""Confined compression of the library's plane microstructure: four stages in numbers, and what they depend on."""

import numpy as np
import pytest

import snowmpm
from snowmpm.render.compression_plot import curve_of
from snowmpm.results.compression import stages
from snowmpm.setup.random_microstructure import random_microstructure


def test_the_sample_has_the_density_of_its_image():
    """Mass and volume of particles are those of the voxels, at any grid."""
    for name, fraction, volume in (("microstructure_2d", 0.65, 5e-3**2), ("microstructure", 0.36, 2.4e-3**3)):
        scene = snowmpm.load_scene(name)
        with np.load(scene.base_dir / scene.bodies[0].shape.file) as archive:
            exact = float(archive["phase"].mean())
        assert exact == pytest.approx(fraction, rel=0.02)
        for coarser in (1.0, 1.7):
            refined = snowmpm.load_scene(name, {"solver.dx": coarser * scene.solver.dx})
            mass = snowmpm.Simulation(refined).audit()["mass"]
            assert mass == pytest.approx(917.0 * exact * volume, rel=1e-6)


@pytest.mark.slow
def test_the_four_stages_of_confined_compression(tmp_path):
    """The cube of the library on a grid of 20 cells: elastic rise, softening, collapse, densification.

    The skeleton is far softer and weaker than ice: modulus and peak below their share of ice; after the peak bonds are
    gone, and what carries is friction of fragments; pores of 64 per cent close by 64 per cent of strain at the latest.
    """
    scene = snowmpm.load_scene("microstructure", {"solver.dx": 1.2e-4})
    run = snowmpm.run(scene, tmp_path)
    found = stages(curve_of(run))
    ice, fraction = scene.materials["ice"], 0.36
    strength = 2.0 * ice.cohesion * np.cos(np.pi / 6.0) / (1.0 - np.sin(np.pi / 6.0))  # uniaxial, 30 degrees
    assert 0.02 < found.modulus / (fraction * ice.youngs_modulus) < 0.5
    assert 0.02 < found.peak_stress / (fraction * strength) < 0.5
    assert found.peak_strain < 0.03
    assert found.softened < 0.6 * found.peak_stress
    assert found.softened < found.plateau < found.peak_stress
    assert found.peak_strain + 0.1 < found.densification < 1.0 - fraction
    assert found.end_stress > 3.0 * found.plateau
    assert found.hardening > 5.0 * found.plateau / (1.0 - fraction)
    assert run.history["unconverged"][-1] == 0


@pytest.mark.slow
def test_collapse_at_an_almost_constant_stress(tmp_path):
    """A cube of 1.6 mm of the library's kind of snow on cells of 0.12 mm: after the peak the piston goes on from 12 to
    40 per cent of strain under 0.70 to 1.24 MPa, a quarter more at the end than at the start, and needs twenty times as
    much at 50.

    The height of that plateau is this sample's and not yet snow's: 0.85 and 0.68 MPa on cells of 0.12 and 0.08 mm, as
    fragments touch a cell before they meet; and in the library's cube, of 3.4 times the volume and with other grains,
    the stress grows from 0.15 to 1.2 MPa on the same way. Both are some ten grains high.
    """
    voxels, side = random_microstructure((32, 32, 32), 0.36, 3.0, seed=3), 32 * 5e-5
    np.savez(tmp_path / "cube.npz", phase=voxels)
    run = snowmpm.run(snowmpm.load_scene("microstructure", {
        "solver.dx": 1.2e-4, "bodies.0.shape.file": str(tmp_path / "cube.npz"), "end_time": 2.6e-4,
        "domain.max": [side, side, 1.25 * side], "obstacles.0.shape.min": [-0.5 * side, -0.5 * side, side],
        "obstacles.0.shape.max": [1.5 * side, 1.5 * side, 1.125 * side], "output.interval": 4e-5}), tmp_path / "run")
    curve = curve_of(run)
    found = stages(curve)
    assert found.peak_strain < 0.05 and found.softened < 0.6 * found.peak_stress
    collapse = curve.stress[(curve.strain > 0.12) & (curve.strain < 0.4)]
    assert collapse.min() > 0.7 * collapse.mean() and collapse.max() < 1.45 * collapse.mean()
    assert np.interp(0.5, curve.strain, curve.stress) > 10.0 * collapse.mean()
    assert found.densification < 0.4

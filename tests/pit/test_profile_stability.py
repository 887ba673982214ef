"""Critical lengths of a profile beside formulas written out here, and what the intervals do."""

import math
from dataclasses import replace

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.pit import mechanics, stability
from snowmpm.pit.column import THICKEST, Column, Plate, WeakLayer, column_of
from snowmpm.pit.reader import read_profile
from snowmpm.pit.weak_layers import candidates
from snowmpm.saw_test import theory, weac
from tests.support.snow_pits import caaml, write

WEAK = WeakLayer(0.02, 160.0, "hardness", 1.5, 1e6, 1200.0, 0.56)


WHOLE = (Plate(0.5, 200.0, 4e6, "hardness"),)


def of(angle=30.0, plates=WHOLE, **weak):
    return Column(tuple(plates), replace(WEAK, **weak), angle, "bergfeld")


@pytest.fixture
def column(tmp_path):
    read = read_profile(write(tmp_path))
    return column_of(read, candidates(read)[0].index)


def test_the_column_is_normal_to_the_slope_and_bottom_up(column):
    cos = math.cos(math.radians(36.0))
    assert [plate.thickness for plate in column.plates] == pytest.approx([0.15 * cos] * 3)
    assert [round(plate.density) for plate in column.plates] == [202, 160, 81]
    assert [plate.source for plate in column.plates] == ["hardness", "measured", "hardness"]
    assert column.weak.thickness == pytest.approx(0.03 * cos)
    assert column.stresses[1] / column.stresses[0] == pytest.approx(math.tan(math.radians(36.0)))
    # The weight of the slab on a square metre of slope is the same as its vertical load times cos
    weight = 9.81 * 0.15 * (81.0 + 160.0 + 154.0 + 1.51 * 3.0**3.15)
    assert math.hypot(*column.stresses) == pytest.approx(weight * cos)


def test_what_the_profile_does_not_say_is_told(tmp_path):
    read = read_profile(write(tmp_path, text=caaml(angle="")))
    found = column_of(read, 3)
    assert found.angle == 0.0
    assert found.assumed[0] == "the file has no slope angle: taken as level; --slope gives one"
    assert column_of(read, 3, 41.0).angle == 41.0
    assert "2 of 3 layers of the slab" in " ".join(found.assumed)


def test_at_the_bottom_of_a_thick_layer_its_last_centimetres_fail(tmp_path):
    layers = [(0, 20, "RG", 0.4, "1F", None), (20, 50, "FC", 1.5, "F", None), (50, 90, "RG", 0.4, "P", None)]
    read = read_profile(write(tmp_path, text=caaml(layers, angle="0", tests=())))
    found = column_of(read, 1, depth=0.5)
    assert (found.thickness, found.weak.thickness) == pytest.approx((0.45, 0.05))


def test_snow_that_is_not_described_weighs_as_the_layer_below_it(tmp_path):
    layers = [(5, 20, "PP", 1.0, "F", None), (30, 50, "RG", 0.4, "1F", None), (50, 53, "DH", 2.0, "F", None)]
    found = column_of(read_profile(write(tmp_path, text=caaml(layers, angle="0", tests=()))), 2)
    assert found.thickness == pytest.approx(0.5)
    assert [(round(plate.thickness, 3), round(plate.density)) for plate in found.plates] == [
        (0.2, 202), (0.1, 202), (0.15, 81), (0.05, 81)]


def test_a_layer_of_two_hardnesses_counts_as_two(tmp_path):
    text = caaml().replace("<hardness uom=''>1F</hardness>",
                           "<hardnessTop uom=''>4F</hardnessTop><hardnessBottom uom=''>P</hardnessBottom>")
    plates = column_of(read_profile(write(tmp_path, text=text)), 3).plates
    assert [round(plate.density) for plate in plates[:2]] == [273, 167]


def test_of_a_thick_weak_layer_a_part_takes_part(tmp_path):
    read = read_profile(write(tmp_path, text=caaml().replace(">48<", ">70<").replace(
        "<thickness uom='cm'>3</thickness>", "<thickness uom='cm'>25</thickness>").replace(
        "<thickness uom='cm'>42</thickness>", "<thickness uom='cm'>20</thickness>")))
    assert column_of(read, 3).weak.thickness == THICKEST == 0.05


def test_what_lies_above_the_depth_of_the_test_belongs_to_the_slab(tmp_path):
    layers = [(0, 45, "RG", 0.4, "1F", None), (45, 65, "DH", 2.5, "F", None), (65, 90, "RG", 0.4, "P", None)]
    read = read_profile(write(tmp_path, text=caaml(layers, angle="0", tests=())))
    whole, deeper = column_of(read, 1), column_of(read, 1, depth=0.5)
    assert (whole.thickness, deeper.thickness) == pytest.approx((0.45, 0.5))
    assert deeper.weak.thickness == THICKEST
    assert [round(plate.density) for plate in deeper.plates] == [210, 202]  # depth hoar, fist, below rounded grains


def test_no_density_and_no_slab_are_refused(tmp_path):
    layers = [(0, 20, "", 1.0, "", None), (20, 25, "DH", 1.0, "F", None)]
    read = read_profile(write(tmp_path, text=caaml(layers, tests=())))
    with pytest.raises(InputError, match=r"layer 1, 0 to 20 cm: density is missing"):
        column_of(read, 1)
    with pytest.raises(InputError, match="no slab above it"):
        column_of(read, 0)


def test_by_strength_is_the_published_formula():
    """Written out with the numbers of Richter et al. (2019): E' of the mean density, F_wl of density and grain size."""
    column = of()
    sigma, tau = 9.81 * 200.0 * 0.5 * math.cos(math.radians(30.0)), 9.81 * 200.0 * 0.5 * math.sin(math.radians(30.0))
    plate = 5.07e9 * (200.0 / 917.0) ** 5.13 / (1.0 - 0.04)
    softness = 4.7e-9 * (160.0 / 917.0 * 1.5 / 1.25) ** -2.1
    wanted = math.sqrt(plate * 0.5 * softness) * (-tau + math.sqrt(tau**2 + 2.0 * sigma * (1200.0 - tau))) / sigma
    assert stability.by_strength(column) == pytest.approx(wanted, rel=1e-9)


def test_a_layer_that_does_not_bear_its_slab_has_no_length():
    found = stability.stability_of(of(strength=300.0), samples=0, use_weac=False).length("strength")
    assert found.value == 0.0
    assert found.why == "would fail under the weight of the slab alone"


def test_by_energy_is_the_rate_of_the_saw_test():
    column = of(10.0)
    length = stability.by_energy(column)
    rate = theory.energy_release_rate(column.slab, *column.stresses, length)
    assert rate == pytest.approx(WEAK.energy, rel=1e-9)
    assert stability.by_energy(of(10.0, energy=1e6)) == stability.CAP


@pytest.mark.skipif(not weac.version(), reason="needs the package weac")
def test_weac_is_asked_with_the_column_of_the_profile():
    """Layers from the weak layer up, and an upslope cut: the heavy layer below makes the cut shorter, a soft weak layer
    too, and a cut downslope would be longer."""
    heavy, light = Plate(0.25, 300.0, 4e6, "hardness"), Plate(0.25, 100.0, 4e6, "hardness")
    found = stability.by_weac(of(plates=(heavy, light)))
    direct = {angle: weac.critical_length_of([(0.25, heavy), (0.25, light)], WEAK, 0.02, slope_angle=angle, length=5.0,
                                             ends="normal", energy=0.56) for angle in (30.0, -30.0)}
    assert found == direct[30.0] < direct[-30.0]
    assert stability.by_weac(of(youngs_modulus=1e5)) < stability.by_weac(of(youngs_modulus=1e7))


def test_tension_is_that_of_a_cantilever():
    """3 sigma a2 / D2 + tau a / D, over the strength."""
    column = of()
    sigma, tau = column.stresses
    wanted = (3.0 * sigma * 0.4**2 / 0.5**2 + tau * 0.4 / 0.5) / mechanics.tensile_strength(200.0)
    assert stability.tension(column, 0.4) == pytest.approx(wanted, rel=1e-9)


def test_a_slab_cut_into_layers_of_one_snow_is_the_same_slab():
    whole, parts = of(), of(plates=[Plate(0.125, 200.0, 4e6, "hardness")] * 4)
    for critical in (stability.by_strength, stability.by_energy):
        assert critical(parts) == pytest.approx(critical(whole), rel=1e-6)
    assert stability.tension(parts, 0.3) == pytest.approx(stability.tension(whole, 0.3), rel=1e-9)


def test_speeds_are_those_of_the_theories():
    flat, steep = of(0.0), of(38.0)
    fall = mechanics.collapse_height(0.02)
    assert stability.crack_speed(flat) == (theory.collapse_speed(flat.slab, fall), "collapse")
    assert stability.crack_speed(steep)[0] == steep.slab.plate_speed


def test_intervals_hold_the_value_and_repeat(column):
    found, again = (stability.stability_of(column, use_weac=False) for _ in range(2))
    assert found == again
    for one in found.lengths:
        assert one.low < one.value < one.high
        assert len(one.shares) == len(stability.INPUTS)
        assert 0.5 < sum(one.shares) < 1.1


def test_the_interval_is_as_wide_as_the_scatter():
    """On the flat the length by strength goes with the root of the strength: its scatter is half of that."""
    rows = stability.hypercube(4000)
    only = np.zeros_like(rows)
    only[:, 3] = rows[:, 3]
    only[:, 1] = 0.1
    weak = of(0.0, plates=(Plate(0.3, 150.0, 4e6, "hardness"),), strength=500.0, strength_exponent=0.0, size=3.0)
    lengths = np.log([stability.by_strength(stability.sampled(weak, row)) for row in only])
    assert lengths.std() == pytest.approx(0.5 * mechanics.STRENGTH_SCATTER, rel=0.15)
    assert stability.INTERVAL == (0.1, 0.9)
    assert (stability.ANGLE_SCATTER, stability.SIZE_SCATTER) == (2.0, 0.3)


def test_the_strength_of_a_column_follows_its_density():
    """By the exponent of its law, so that the scatter of the density is in the interval by strength."""
    column = of(0.0, strength_exponent=2.11)
    row = np.zeros(len(stability.INPUTS))
    row[stability.INPUTS.index("weak-layer density")] = 1.0
    dense = stability.sampled(column, row).weak
    ratio = math.exp(mechanics.DENSITY_SCATTER["hardness"])
    assert dense.density == pytest.approx(ratio * WEAK.density)
    assert dense.strength == pytest.approx(ratio**2.11 * WEAK.strength)


def test_speed_and_tension_have_intervals_too(column):
    found = stability.stability_of(column, use_weac=False)
    assert found.speeds[0] < found.crack_speed < found.speeds[1]
    assert found.tensions[0] < found.tension < found.tensions[1]
    assert 0.0 <= found.tears <= 1.0


def test_an_input_without_influence_has_no_share(column):
    """The collapse energy does not enter by strength, nor the strength by energy."""
    found = stability.stability_of(column, use_weac=False)
    share = {one.theory: dict(zip(stability.INPUTS, one.shares, strict=True)) for one in found.lengths}
    assert share["strength"]["collapse energy"] < 0.1  # of 96 columns: chance
    assert share["energy"]["weak-layer strength"] < 0.1
    assert share["energy"]["collapse energy"] > 0.2


def test_shares_of_a_product_are_those_of_its_logarithms():
    rows = stability.hypercube(4096)
    found = np.exp(0.8 * rows[:, 0] + 0.6 * rows[:, 3])
    shares = stability.variance_shares(found, rows)
    # Four bins catch 0.86 of a linear share
    assert shares[0] == pytest.approx(0.86 * 0.64, abs=0.02)
    assert shares[3] == pytest.approx(0.86 * 0.36, abs=0.02)
    assert max(shares[1], shares[2], shares[4], shares[5]) < 0.02


def test_less_scatter_makes_a_narrower_interval(column):
    known = replace(column, plates=tuple(replace(plate, source="measured") for plate in column.plates))
    wide, narrow = (stability.stability_of(one, use_weac=False).length("strength") for one in (column, known))
    assert narrow.high / narrow.low < wide.high / wide.low

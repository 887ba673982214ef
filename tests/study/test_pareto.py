"""What a table of measurements says: fronts, orders, floors, time to the same error."""

import dataclasses

import numpy as np
import pytest

from snowmpm.study.measurement import Measurement, read, write
from snowmpm.study.pareto import Refinement, front, merged, noise, orders, time_to


def row(cells, error, seconds, variation="program"):
    return Measurement("waves", variation, 2, "quadratic", "affine", "apic", 0.0, "f32", 0.4, 2, cells, 4 * cells**2,
                       cells, 4 * cells**3, seconds, error)


def second_order(floor=0.0):
    return [row(n, (1.0 / n) ** 2 + floor, 1e-6 * n**3) for n in (8, 16, 32, 64, 128)]


def test_the_front_holds_what_nothing_beats():
    rows = [row(8, 0.1, 1.0), row(16, 0.02, 4.0), row(16, 0.05, 2.0, "cubic"), row(8, 0.2, 1.5, "cubic")]
    assert [(r.error, r.seconds) for r in front(rows)] == [(0.1, 1.0), (0.05, 2.0), (0.02, 4.0)]


def test_order_without_a_floor():
    found = Refinement.of(second_order())
    assert found.order == pytest.approx(2.0) and found.floor is None and found.range == (8, 128)
    assert [order for *_, order in orders(second_order())] == pytest.approx([2.0] * 4)


def test_a_floor_ends_the_order():
    found = Refinement.of(second_order(floor=(1.0 / 32) ** 2))
    assert found.floor == 32 and found.range == (8, 32)
    assert 1.5 < found.order < 2.0


def test_time_to_an_error_lies_between_grids_and_not_beyond():
    rows = second_order()
    assert time_to(rows, rows[1].error) == pytest.approx(rows[1].seconds)
    between = np.sqrt(rows[1].error * rows[2].error)
    assert time_to(rows, between) == pytest.approx(np.sqrt(rows[1].seconds * rows[2].seconds))
    assert np.isnan(time_to(rows, 0.5 * rows[-1].error)) and np.isnan(time_to(rows, 2.0 * rows[0].error))


def test_repeats_are_noise_and_the_least_of_them_counts():
    rows = [row(8, 0.1, 1.0), row(8, 0.1, 1.5), row(16, 0.05, 2.0)]
    assert noise(rows) == pytest.approx((0.5, 0.0))
    assert [r.seconds for r in merged(rows)] == [1.0, 2.0]
    assert noise(rows[1:]) == (0.0, 0.0)


def test_a_table_comes_back_as_it_was(tmp_path):
    rows = second_order()
    assert read(write(rows, tmp_path / "deep" / "table.csv")) == rows
    assert {type(getattr(read(tmp_path / "deep" / "table.csv")[0], field.name)) for field in
            dataclasses.fields(Measurement)} == {str, int, float}

"""The table of quantities: one definition a name, and numbers as people write them."""

import importlib

import pytest

from snowmpm.quantities.classes import PRESSURE, classes_of
from snowmpm.quantities.quantity import THIN, written
from snowmpm.quantities.saw import SAW_TEST
from snowmpm.quantities.table import (
    GAUGES,
    HISTORY,
    IMPACT,
    NUMBERS,
    OVER_TIME,
    PASSED,
    PATH,
    POWDER_LAYER,
    QUANTITIES,
    RASTERS,
    quantity,
    units_of,
)


@pytest.mark.parametrize(("value", "unit", "decimals", "text"), [
    (1970.4, "m", None, "1970 m"), (27.345, "m/s", None, "27.3 m/s"), (12_400.0, "Pa", None, "12.4 kPa"),
    (980.0, "Pa", None, "980 Pa"), (247345.13, "m", 1, "247345.1 m"), (122_408.0, "m3", None, f"122{THIN}408 m³"),
    (0.0234, "m", None, "0.0234 m"), (5.27, "m", None, "5.27 m"), (0.0, "m", None, "0 m"),
    (21.84, "degrees", 1, "21.8°"), (0.983, "share", None, "98.3 %"), (3.06e7, "kg", None, f"30{THIN}600 t"),
    (1234.6, "kg", None, "1235 kg"),
    (1.23e9, "J", None, "1.23 GJ"), (3.1e-7, "1", None, "3.1e-07"), (float("nan"), "m", None, "-"),
    (-1970.4, "m", None, "-1970 m"), (4.0, "1", None, "4"),
])
def test_numbers_as_people_write_them(value, unit, decimals, text):
    assert written(value, unit, decimals) == text


def test_no_number_of_an_avalanche_has_a_power_of_ten():
    for one in (*RASTERS, *NUMBERS, *GAUGES, *PATH):
        for value in (0.012, 1.97, 27.3, 199.6, 1970.4, 19704.0, 2.1e6, 9.9e8):
            assert "e+" not in one.text(value) and "e-" not in one.text(value), one.name


def test_each_name_is_defined_once_where_it_is_computed():
    names = [one.name for one in (*HISTORY, *RASTERS, *PASSED, *OVER_TIME, *IMPACT, *GAUGES, *PATH, *SAW_TEST,
                                   *POWDER_LAYER)]
    names += [one.name for one in NUMBERS if one not in HISTORY]
    assert len(names) == len(set(names)) == len(QUANTITIES)
    labels = [one.label for one in QUANTITIES.values()]
    assert len(labels) == len(set(labels))
    for one in QUANTITIES.values():
        assert one.definition.endswith(".") and importlib.import_module(one.where)
    assert quantity("steps_fixed").label == "steps fixed" and quantity("steps_fixed").definition == ""


def test_what_is_computed_is_in_the_table():
    from snowmpm.results import maps
    from snowmpm.running import audit as diagnostics

    assert units_of(HISTORY) == diagnostics.UNITS and units_of((*RASTERS, *PASSED)) == maps.UNITS
    assert set(diagnostics.UNITS.values()) <= {"kg", "kg m/s", "kg m2/s", "J", "1", "m/s", "m", "s"}


def test_classes_are_the_same_for_all_runs_but_small_models():
    assert classes_of("peak_pressure", 9e5) == PRESSURE == classes_of("peak_pressure", 2e3)
    assert classes_of("peak_depth", 0.3).limits == (0.05, 0.1, 0.2, 0.4, 0.8)
    assert classes_of("arrival_time", 79.9).limits == (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0)
    assert classes_of("arrival_time", 3.0).limits[0] == 0.5 and classes_of("something", 1.0) is None
    assert [PRESSURE.label(k) for k in (0, 1, 6)] == ["below 1 kPa", "1 to 3 kPa", "300 kPa and above"]

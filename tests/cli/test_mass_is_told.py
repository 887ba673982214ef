"""check and run say that bodies share a place."""

import pytest

SCENE = """
name = "b"
dimension = 2
end_time = 0.02
output = { interval = 0.01 }
solver = { dx = 0.1 }
domain = { min = [0.0, 0.0], max = [1.0, 1.0], boundary = "slip" }
materials.snow = { kind = "elastic", density = 300.0, youngs_modulus = 1e5, poisson_ratio = 0.2 }
[[bodies]]
name = "one"
material = "snow"
shape = { kind = "box", min = [0.2, 0.0], max = [0.6, 0.4] }
[[bodies]]
name = "two"
material = "snow"
shape = { kind = "box", min = [0.2, 0.0], max = [0.6, 0.4] }
"""


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_check_and_run_say_it(call, tmp_path):
    (tmp_path / "s.toml").write_text(SCENE)
    told = "shares 0.16 m2, 100% of the smaller, with one: its mass counts twice there"
    checked = call("check", "s.toml")
    assert told in checked.out and "warnings: none" not in checked.out
    assert told in call("run", "s.toml", "--threads", "1").err

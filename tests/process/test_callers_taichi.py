"""A program that uses Taichi itself, before and after: nothing of its own is lost, and results are the same bits."""

from types import SimpleNamespace

import pytest
import taichi as ti

from snowmpm.compiler import patches, runtime
from snowmpm.errors import InputError

CALLER = """
ti.init(arch=ti.cpu, SETTINGS)
field, array, vectors = ti.field(ti.f32, 8), ti.ndarray(ti.f32, 8), ti.Vector.ndarray(2, ti.f32, 8)

@ti.kernel
def count(a: ti.types.ndarray(dtype=ti.f32, ndim=1)) -> float:
    for i in a:
        a[i] += 1
        field[i] += 1
    return 1 / 3

count(array)
from taichi.lang import impl
before = {name: getattr(impl.current_cfg(), name) for name in dir(impl.current_cfg()) if name[0] != "_"}
print(go_on(block()))
print(go_on(block("f64")))
third = count(array)
assert (array.to_numpy() == 2).all() and (field.to_numpy() == 2).all(), (array.to_numpy(), field.to_numpy())
assert abs(third - 1 / 3) < (1e-15 if impl.get_runtime().default_fp == ti.f64 else 1e-7), third
vectors.from_numpy(np.ones((8, 2), np.float32))
assert vectors[3][1] == 1
assert before == {name: getattr(impl.current_cfg(), name) for name in before}
print(snowmpm.start(), snowmpm.compiler.runtime.threads())
"""


@pytest.mark.parametrize(("settings", "threads"), [
    pytest.param("cpu_max_num_threads=2", 2, marks=pytest.mark.slow),
    ("default_ip=ti.i64, default_fp=ti.f64, fast_math=False, debug=True, short_circuit_operators=False,"
     " advanced_optimization=False, cpu_max_num_threads=1", 1)])
def test_started_before_by_the_caller(program, expected, settings, threads):
    """Its backend and threads are used, its settings hold for its own kernels, ours for ours."""
    said = program(CALLER.replace("SETTINGS", settings))
    assert said == [expected["f32"], expected["f64"], f"cpu {threads}"]


def test_started_before_on_a_backend_that_is_not_ours(monkeypatch):
    monkeypatch.setattr(runtime, "_running", {})
    monkeypatch.setattr(runtime.impl, "current_cfg", lambda: SimpleNamespace(arch=ti.vulkan))
    with pytest.raises(InputError, match=r"runs on vulkan.*\n.*starts Taichi itself"):
        runtime.start()


ENDED = """
old = block()
go_on(old)
old_arrays = [ti.ndarray(ti.f32, 50) for _ in range(200)] + [ti.Vector.ndarray(2, ti.f32, 50) for _ in range(200)]
fields = old.particles
AFTERWARDS
for use in (old.step, old.audit, old.state, lambda: old.particles, lambda: go_on(old),
            lambda: old.solver.step(1e-5), lambda: old.solver.particles.table(), old_arrays[0].to_numpy):
    try:
        use()
        raise SystemExit(f"{use} did something")
    except EndedError as error:
        assert str(error).count("\\n") == 1, error
    except RuntimeError as error:
        assert str(error).startswith("Taichi is not running"), error
assert np.isfinite(fields["position"]).all()  # a copy
new = block()
several = [ti.ndarray(ti.f32, 50) for _ in range(400)]
del old, old_arrays
gc.collect()
for array in several:
    array.fill(1.0)
print(go_on(new))
assert all((array.to_numpy() == 1).all() for array in several)
print(in_parallel() == in_parallel(60000))
"""


@pytest.mark.skipif(not patches.wanted("array_lifetime"), reason="arrays do not know their Taichi: patch switched off")
@pytest.mark.parametrize("afterwards", [
    pytest.param("ti.init(arch=ti.cpu)", marks=pytest.mark.slow), "ti.reset()",
    pytest.param("snowmpm.start(); ti.reset(); block()", marks=pytest.mark.slow)])
def test_ended_afterwards_by_the_caller(program, expected, afterwards):
    """Old simulations say so, whatever is asked of them; new ones work, also while the old ones' memory is freed."""
    assert program(ENDED.replace("AFTERWARDS", afterwards)) == [expected["f32"], "True"]


def test_a_function_edited_and_loaded_again(program):
    """As in a notebook: the source that is compiled is that of the file now."""
    assert program("""
import importlib, pathlib, time
sys.path.insert(0, ".")
sys.dont_write_bytecode = True
file = pathlib.Path("edited.py")
TEXT = '''import taichi as ti
@ti.kernel
def number() -> int:
    return VALUE
'''
snowmpm.start()
file.write_text(TEXT.replace("VALUE", "1"))
import edited
print(edited.number())
file.write_text("# more\\n\\n" + TEXT.replace("VALUE", "22"))
importlib.reload(edited)
print(edited.number())
""") == ["1", "22"]


def test_what_runs_and_is_not_what_is_asked_for():
    with pytest.warns(UserWarning, match=r"on the cpu with \d+ threads: no backend 'cuda' and no 77 threads"):
        assert runtime.start("cuda", 77) == "cpu"

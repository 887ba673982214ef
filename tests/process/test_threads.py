"""Several simulations, precisions and threads in one process: the same bits as alone."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import snowmpm
from tests.support.same_runs import assert_same

BLOCK = Path(__file__).parents[1] / "cli" / "block.toml"
PRECISIONS = ["f32", "f64", "f32", "f64"]


def block(precision):
    return snowmpm.Simulation(snowmpm.load_scene(BLOCK, {"solver.precision": precision}))


def steps(simulation, n=30):
    for _ in range(n):
        simulation.step()
    return simulation.state()


@pytest.fixture(scope="module")
def alone():
    return {precision: steps(block(precision)) for precision in ("f32", "f64")}


def test_two_take_turns(alone):
    one, other = block("f32"), block("f64")
    for _ in range(30):
        one.step()
        other.step()
    assert_same(one.state(), alone["f32"])
    assert_same(other.state(), alone["f64"])


def test_a_thread_each(alone):
    """Built and stepped by four threads at a time."""
    with ThreadPoolExecutor(4) as pool:
        states = list(pool.map(lambda precision: steps(block(precision)), PRECISIONS))
    for precision, state in zip(PRECISIONS, states, strict=True):
        assert_same(state, alone[precision])


def test_stepped_by_others_than_the_thread_that_made_it(alone):
    """Also by several at a time: a step is whole before the next one begins."""
    simulation = block("f64")
    with ThreadPoolExecutor(3) as pool:
        list(pool.map(lambda _: steps(simulation, 10), range(3)))
    assert_same(simulation.state(), alone["f64"])


def test_runs_of_several_threads(tmp_path):
    with ThreadPoolExecutor(2) as pool:
        runs = list(pool.map(lambda name: snowmpm.run(snowmpm.load_scene(BLOCK), tmp_path / name), "ab"))
    assert all(run.complete for run in runs)
    assert_same(runs[0].frame(2).points, runs[1].frame(2).points)


def test_started_and_ended_in_a_thread(program, expected):
    """As in a server: Taichi is not the main thread's, whose end is the program's, and an event loop goes on."""
    assert program("""
import asyncio

async def main():
    waited = 0
    work = asyncio.create_task(asyncio.to_thread(lambda: go_on(block())))
    while not work.done():
        await asyncio.sleep(0.01)
        waited += 1
    print(await work, waited > 3)

asyncio.run(main())
print(go_on(block("f64")))
""") == [f"{expected['f32']} True", expected["f64"]]

"""Processes made by fork and spawn, before and after Taichi was started: each computes, or says why it cannot."""

import os

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")

FORK = """
def forked(action):
    "Exit code of a child that does this and ends as any program does."
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        action()
        sys.exit(7)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
"""


def test_forked_after_the_start(program, expected):
    """The child may start Taichi anew, also the child of a child; what it has from its parent says that it cannot."""
    said = program(FORK + """
old, total = block(), in_parallel()
first = go_on(old, 10)

def child():
    try:
        old.step()
    except EndedError as error:
        print(str(error).splitlines()[0])
    print(go_on(block()), in_parallel() == total)
    assert forked(lambda: print(go_on(block()), in_parallel() == total)) == 7
    print(go_on(block("f64")))

assert forked(child) == 7
assert forked(lambda: None) == 7
print(go_on(old, 10))
""")
    assert said == ["this simulation belongs to the process that this one was forked from, whose threads are not here:",
                    f"{expected['f32']} True", f"{expected['f32']} True", expected["f64"], expected["f32"]]


@pytest.mark.slow
def test_forked_before_the_start(program, expected):
    said = program(FORK + "assert forked(lambda: print(go_on(block()))) == 7; print(go_on(block()))")
    assert said == [expected["f32"]] * 2


def test_forked_by_another_thread(program, expected):
    """Taichi can be ended only by the thread that started it, and two of them cannot be."""
    said = program(FORK + """
block()

def refused():
    try:
        block()
    except EndedError as error:
        print(str(error).replace("\\n", " "), flush=True)
    os._exit(7)  # only a main thread ends a program by sys.exit

thread = threading.Thread(target=lambda: print(forked(refused)))
thread.start()
thread.join()
""")
    assert said[0].startswith("Taichi cannot be started again in a process that was forked by another thread")
    assert "spawn" in said[0] and said[1:] == ["7"]


def test_forked_while_another_thread_computes(program, expected):
    """The other thread's turn does not end in the child."""
    said = program(FORK + """
from snowmpm.compiler.settings import compiling
snowmpm.start()
inside, done = threading.Event(), threading.Event()

def compute():
    with compiling():
        inside.set()
        done.wait()

thread = threading.Thread(target=compute)
thread.start()
inside.wait()
assert forked(lambda: print(go_on(block()))) == 7
done.set()
thread.join()
""")
    assert said == [expected["f32"]]


@pytest.mark.parametrize("method", [
    "fork", *(pytest.param(name, marks=pytest.mark.slow) for name in ("spawn", "forkserver"))])
def test_pools(program, expected, method):
    """Workers of concurrent.futures, made by each method of multiprocessing, with Taichi at work in the parent."""
    said = program(f"""
import multiprocessing
from concurrent.futures import ProcessPoolExecutor

def work(precision):
    return go_on(block(precision)), in_parallel()

if __name__ == "__main__":
    total, context = in_parallel(), multiprocessing.get_context("{method}")
    block()
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        for found, other in pool.map(work, ["f32", "f64"]):
            print(found, other == total)
""")
    assert said == [f"{expected['f32']} True", f"{expected['f64']} True"]

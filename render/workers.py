"""Pictures of a film drawn side by side, by threads: NumPy and SciPy compute outside Python's lock.

What draws them multiplies by `np.einsum`, not by `@`, which hands products to BLAS: its own threads have been seen to
wait for each other without end where two pictures were drawn at a time on a busy machine.
"""

from collections import deque
from concurrent.futures import ThreadPoolExecutor

from snowmpm import memory
from snowmpm.cores import available_cores

PER_PARTICLE = 300
"""Bytes that a picture takes at most while it is drawn, for each particle in it (measured: 230)."""

PER_PIXEL = 200
"""Bytes that it takes for each of its pixels (measured: up to 150, where snow fills the picture)."""

MOST = 8
"""Threads that share Python's lock with gain."""


def worker_count(size, particles, pictures):
    """Threads for a film of pictures of `size` (width, height) with at most so many particles: one a core, as far as
    half of the free memory goes."""
    each = PER_PARTICLE * particles + PER_PIXEL * size[0] * size[1]
    return max(1, min(available_cores(), MOST, pictures, int(0.5 * memory.available() / each)))


def drawn(draw, numbers, workers):
    """`draw(i)` for each of the numbers, in their order; at most two more than `workers` are drawn or wait at any time.

    When the consumer stops early, pictures that are begun are finished, and the others are not drawn.
    """
    if workers == 1:
        yield from map(draw, numbers)
        return
    waiting = deque()
    with ThreadPoolExecutor(workers, thread_name_prefix="picture") as pool:
        try:
            for i in numbers:
                waiting.append(pool.submit(draw, i))
                # The next ones are drawn while the consumer has this one
                if len(waiting) > workers + 1:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for picture in waiting:
                picture.cancel()

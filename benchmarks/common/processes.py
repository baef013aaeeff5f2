"""Parts of a benchmark that measures no time, in several processes."""

import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor


def spread(function: Callable, parts: Iterable, jobs: int) -> Iterator:
    """Results of a function for parts, in their order.

    Parameters
    ----------
    function : callable    Of a module, so that another process finds it.
    parts : iterable    What it is given, one each time.
    jobs : int    Processes; 1: this one.
    """
    if jobs == 1:
        yield from map(function, parts)
        return
    # Dr.Jit's threads do not live on in forks.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        yield from pool.map(function, parts)

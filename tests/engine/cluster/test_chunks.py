"""Cutting jobs into chunks: samples, seeds, and each chunk counted once."""

from itertools import islice

import numpy as np

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.cluster.chunks import Grain, Tally, cut, seed_of

GRAIN = Grain(1024, 8192, 16)


def test_chunks_have_the_samples_that_are_asked_for():
    for samples in (16, 1024, 5000, 100_000, 1_234_567):
        chunks = list(cut(StopRule(samples=samples), 3, GRAIN))
        total = sum(chunk.samples for chunk in chunks)
        assert samples <= total < samples + GRAIN.step
        assert [chunk.number for chunk in chunks] == list(range(len(chunks)))


def test_no_chunk_is_too_small_to_tell_its_error():
    for samples in (5000, 9000, 100_000):
        sizes = [chunk.samples for chunk in cut(StopRule(samples=samples), 3, GRAIN)]
        assert min(sizes) >= GRAIN.least
        assert max(sizes) < GRAIN.most + GRAIN.least


def test_longer_jobs_begin_with_the_same_chunks():
    short = list(cut(StopRule(samples=50_000), 7, GRAIN))
    endless = list(islice(cut(StopRule(error=0.01), 7, GRAIN), len(short)))
    assert endless[:-1] == short[:-1]


def test_seeds_of_a_job_differ():
    seeds = {seed_of(5, number) for number in range(100_000)}
    assert len(seeds) == 100_000
    assert all(0 <= seed < 2**31 for seed in seeds)


def test_seeds_of_neighbouring_jobs_and_chunks_tell_nothing_of_each_other():
    seeds = np.array([[seed_of(job, number) for number in range(200)] for job in range(200)])
    assert len(np.unique(seeds)) > 0.99 * seeds.size
    for axis in (0, 1):
        moved = np.diff(seeds.astype(float), axis=axis) / 2**31
        assert abs(moved.mean()) < 0.02
        assert np.unique(np.diff(seeds, axis=axis)).size > 0.9 * moved.size


def test_answers_come_in_order_and_once():
    tally, given = Tally(), []
    for number in (2, 0, 0, 3, 2, 1, 1, 5, 0):
        tally.take(number, f"answer {number}, {len(given)}")
        given += tally.give()
    assert [answer.split(",")[0] for answer in given] == [f"answer {k}" for k in range(4)]
    assert tally.has(5)
    assert not tally.has(4)

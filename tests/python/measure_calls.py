"""Measures what a call from Python costs over C++; the figures are in docs/figures.md.

    PYTHONPATH=build/release/python CAIRN_MAKE_STREET=build/release/tests/python/cairn_make_street \\
        python3 tests/python/measure_calls.py

Each call is compared with the time that the localizer measures inside of the same call.
"""

import gc
import resource
import time

import numpy as np

import cairn
import street


def cost_of_a_call(map_, query, times=300):
    """Milliseconds: median and 90th percentile of a call, over the localizer's own time."""
    costs, inside = [], []
    for _ in range(times):
        begin = time.perf_counter()
        result = map_.localize(query)
        costs.append(time.perf_counter() - begin - result.stages["total"])
        inside.append(result.stages["total"])
    return 1e3 * np.percentile(costs, [50, 90]), 1e3 * np.median(inside)


def speedup(map_, queries, rounds=5):
    """Ratio of the wall times of one thread and of two, medians of alternating rounds."""
    seconds = {1: [], 2: []}
    for _ in range(rounds):
        for threads in (1, 2):
            begin = time.perf_counter()
            for _ in map_.localize_many(queries, threads=threads):
                pass
            seconds[threads].append(time.perf_counter() - begin)
    return np.median(seconds[1]) / np.median(seconds[2])


def growth(map_, query, calls=10_000):
    """Megabytes that calls add to the resident memory, after a first thousand."""
    def resident():
        gc.collect()
        with open("/proc/self/statm") as pages:
            return int(pages.read().split()[1]) * resource.getpagesize() / 1e6

    for _ in range(1000):
        map_.localize(query)
    before = resident()
    for _ in range(calls):
        map_.localize(query)
    return resident() - before


def as_many(first, count):
    """As many features as a photo has: those of the query over and over."""
    times = -(-count // len(first.keypoints))
    return cairn.Features(np.tile(first.keypoints, (times, 1))[:count].copy(),
                          np.tile(first.descriptors, (times, 1))[:count].copy(), size=first.size)


def main():
    first = street.FirstQuery()
    with cairn.Map(street.map_path()) as map_:
        query = first.query()
        map_.localize(query)
        (median, high), inside = cost_of_a_call(map_, query)
        print(f"a call: {median:.3f} ms over the localizer's {inside:.1f} ms (90 %: {high:.3f} ms)")
        many = as_many(first, 2500)
        big = cairn.Query(many, first.camera, prior=first.prior, gravity=first.gravity)
        (median, high), inside = cost_of_a_call(map_, big, 60)
        print(f"{len(many)} features: {median:.3f} ms over {inside:.1f} ms (90 %: {high:.3f} ms)")
        print(f"two threads: {speedup(map_, [first.query() for _ in range(40)]):.2f} times one")
        few = cairn.Query(cairn.Features(first.keypoints[:2].copy(), first.descriptors[:2].copy(),
                                         size=first.size), first.camera, prior=first.prior)
        print(f"10,000 calls add {growth(map_, few):.2f} MB")


if __name__ == "__main__":
    main()

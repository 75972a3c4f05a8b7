"""Fair times: a run is repeated, and its fastest repetition counts."""

from time import process_time

REPEATED = 0.2
"""CPU time after which a run is repeated no more [s]."""


def fastest(run, repeated=REPEATED):
    """CPU seconds of the fastest of some runs, and the result, which is the same in all of them."""
    best, spent = float("inf"), 0.0
    while spent < repeated:
        start = process_time()
        result = run()
        seconds = process_time() - start
        best, spent = min(best, seconds), spent + seconds + 1e-4
    return best, result

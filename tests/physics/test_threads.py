"""Batches in several threads: as many as allowed, the same numbers, and memory that is still theirs."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np

from eaclutch.physics.kernels import batch


def test_as_many_threads_as_the_process_may_use_and_the_same_numbers(model, runs, monkeypatch):
    started = []

    def pool(workers):
        started.append(workers)
        return ThreadPoolExecutor(workers)

    monkeypatch.setattr(batch, "ThreadPoolExecutor", pool)
    conditions = runs(voltage=np.random.default_rng(5).uniform(100, 300, 1500))
    several = []
    for threads in (3, 1):
        monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", threads)
        several.append(model.predict(conditions).values["release_time_90_s"])
    assert started == [3]
    few = np.concatenate(
        [
            model.predict(conditions.select(np.arange(i, i + 100))).values["release_time_90_s"][0]
            for i in range(0, 1500, 100)
        ]
    )
    assert np.isfinite(few).any()
    assert np.array_equal(*several, equal_nan=True) and np.array_equal(several[0][0], few, equal_nan=True)


def test_what_the_solver_writes_to_is_held_while_it_runs():
    """Where freed memory goes back to the system at once, writing to it is the end of the process."""
    script = """
        import numpy as np
        from conftest import BENCH, make_runs
        from eaclutch.physics.model import ClutchModel
        runs = make_runs(voltage=np.full(2000, 250.0))
        found = ClutchModel(BENCH).predict(runs, None, ["release_time_90_s"]).values["release_time_90_s"]
        assert 0.0 < found[0, 0] < 1e-2 and (found == found[0, 0]).all()
    """
    for threads in ("1", "4"):
        surroundings = {"MALLOC_MMAP_THRESHOLD_": "65536", "NUMBA_NUM_THREADS": threads}
        done = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(script)],
            env=os.environ | surroundings, cwd=Path(__file__).parent, capture_output=True, text=True,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr

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


def test_as_many_threads_as_the_process_may_use(model, runs, monkeypatch):
    started = []

    def pool(workers):
        started.append(workers)
        return ThreadPoolExecutor(workers)

    monkeypatch.setattr(batch, "ThreadPoolExecutor", pool)
    conditions = runs(voltage=np.linspace(150.0, 300.0, 1500))
    found = []
    for threads in (1, 3):
        monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", threads)
        found.append(model.predict(conditions, None, ["release_time_90_s"]).values["release_time_90_s"])
    assert started == [3]
    assert np.isfinite(found[0]).any() and np.array_equal(*found, equal_nan=True)


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

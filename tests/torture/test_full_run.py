"""A run that is killed twice and then started twice at once (benchmarks/torture/full_run.py has the long trials)."""

import os
import time

import pytest
import run_bench

from eaclutch.manifest import verify

pytestmark = pytest.mark.workflow


@pytest.mark.timeout(1200)
def test_a_killed_run_goes_on_and_only_one_works_at_a_time(tmp_path):
    bench, work = run_bench.Bench(tmp_path, 1), tmp_path / "work"
    assert bench.killed(work, 10.0)
    assert bench.killed(work, 20.0)
    tomorrow = time.time() + 86_400  # the clock was set back: all that is there comes from the future
    for path in work.rglob("*"):
        if path.is_file():
            os.utime(path, (tomorrow, tomorrow))
    first = bench.start(work)
    time.sleep(1.0)
    second = bench.start(work)
    assert sorted((first.wait(900), second.wait(900))) == [0, 1], bench.output(work)[-6000:]
    assert [line.split(";")[0] for line in bench.last_lines(work)] == [
        "eaclutch: error: results/tiny: another run makes these results"
    ], bench.output(work)[-6000:]
    assert verify(work / "results" / "tiny") == []
    assert bench.finish(work) == 0

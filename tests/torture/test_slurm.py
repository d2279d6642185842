"""The workflow on a real Slurm (benchmarks/slurm), where one is up; a job of it is killed."""

import importlib.util
import shutil
from pathlib import Path

import pytest

pytestmark = pytest.mark.workflow
_SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "slurm" / "trial.py"
_SPEC = importlib.util.spec_from_file_location("trial", _SCRIPT)
trial = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(trial)


@pytest.mark.timeout(3000)
def test_a_run_on_slurm_whose_job_is_killed_ends_as_one_at_home(tmp_path):
    if not shutil.which("sinfo") or not trial.slurm("sinfo", "-h"):
        pytest.skip("Slurm is not up (benchmarks/slurm/one_node.sh start)")
    bench = trial.run_bench.Bench(tmp_path, 1)
    assert bench.run_reference() == 0
    found = trial.job_killed(bench)
    assert found["happened_to"][0] is not None
    assert found["statuses"][-1] == 0 and found["different"] == []

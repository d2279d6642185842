"""How cost grows: processor time, wall time and peak memory of each stage with runs and with candidates.

    python benchmarks/growth.py --runs 60 600 6000 --candidates 4 16 64

Simulated campaigns at the level of observables: 20 conditions, 20 runs a session. Each stage runs in a process of its
own, as its rule does, so that its peak memory is its own. More candidates than the library has are its own over again:
what a candidate costs is one job. Prints exponents from size to size and records docs/measurements/growth.json;
``--picture growth.png`` draws them.
"""

from __future__ import annotations

import argparse
import os
import pickle
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import date, timedelta
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import matplotlib as mpl
import numpy as np
from measurement import record

from eaclutch.cli.inference import capacity_data, measured_runs
from eaclutch.config import load_config
from eaclutch.diagnosis.conclude import conclude
from eaclutch.diagnosis.inputs import DiagnosisInputs
from eaclutch.diagnosis.pairs import with_pairs
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.study import Study
from eaclutch.files import write_csv
from eaclutch.inference import storage
from eaclutch.inference.parameters import with_priors
from eaclutch.inference.posterior import StageInputs, run_stage, stage_problem
from eaclutch.inference.predict_campaign import predict_campaign
from eaclutch.inference.sampling import SamplerSettings
from eaclutch.physics.effects import BASE
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, Substrate
from eaclutch.simulation.noise import BenchNoise
from eaclutch.simulation.observables import SimulatedTable, simulate_table
from eaclutch.simulation.plan import Plan, sweep

BENCH = Bench("growth", substrates={"brass": Substrate(thickness={w * 1e-3: w * 1e-3 for w in (2, 2.5, 3)})})
CONDITIONS = 20
STAGES = ("dielectric", "load_cell", "contact", "force")
# One length of chain for all sizes: what a likelihood costs, not how soon a gate opens.
CHAINS = SamplerSettings(
    ensembles=2, walkers=24, check_every=250, max_steps=250, stored_draws=250, warm_up=200
)
TRUTH = {"gas_slip.mean_free_path": 1e-6}
EFFECTS = (*BASE, "gas_slip")
PAIRS = 6


def campaign(runs: int) -> SimulatedTable:
    """Twenty conditions, each once a session."""
    centre = {"voltage_v": 300.0, "frequency_hz": 1000.0, "width_mm": 2.0, "preload_n": 0.1}
    conditions = [
        centre | {"voltage_v": v, "frequency_hz": f}
        for v in (200.0, 250.0, 300.0)
        for f in (1.0, 10.0, 100.0, 1e3, 1e4)
    ]
    conditions += [centre | {"width_mm": w} for w in (2.5, 3.0)] + [
        centre | {"preload_n": p} for p in (0.5, 1.0, 2.0)
    ]
    sessions = [date(2025, 3, 3) + timedelta(days=i) for i in range(runs // CONDITIONS)]
    rng = np.random.default_rng(runs)
    return simulate_table(
        Plan(sweep(conditions, sessions, len(sessions), rng)), BENCH, EFFECTS, TRUTH, BenchNoise(), rng
    )


def posterior(folder: Path, made: SimulatedTable, stage: str) -> None:
    """One stage's chains."""
    files = [folder / f"{name}.nc" for name in STAGES[: STAGES.index(stage)]]
    problem = stage_problem(stage, stage_inputs(made, files), np.random.default_rng(7))
    data, _ = run_stage(problem, CHAINS, 1)
    storage.save(folder / f"{stage}.nc", data)


def stage_inputs(made: SimulatedTable, earlier: Sequence[Path]) -> StageInputs:
    model = ClutchModel(BENCH, BASE, force_multiplier_form="linear")
    return StageInputs(
        BENCH, with_priors(model.parameters, {}), made.readings, made.spectra, bursts=made.bursts,
        capacity=capacity_data(made.runs, BENCH), model={"effects": list(BASE)}, earlier=list(earlier),
    )  # fmt: skip


def prediction(folder: Path, made: SimulatedTable) -> None:
    """Every run, in the sample, without its condition and its session, in as many jobs as the workflow makes."""
    inputs = stage_inputs(made, [folder / f"{name}.nc" for name in STAGES])
    model = ClutchModel(BENCH, BASE, force_multiplier_form="linear")
    runs = measured_runs(made.runs, BENCH)
    jobs = -(-len(made.runs) // load_config([], {})["predict"]["runs_per_job"])
    for job in range(jobs):
        table = predict_campaign(model, inputs, runs, seed=1, draws=100, parts=5, job=(job, jobs))
        write_csv(folder / f"predicted_{job}.csv", table)


def study(made: SimulatedTable) -> Study:
    inputs = DiagnosisInputs(BENCH, made.runs, made.readings, made.spectra, made.bursts, BASE)
    return Study(inputs, load_thresholds())


def candidate(folder: Path, made: SimulatedTable, count: int) -> None:
    """Fits of ``count`` candidates (the library's over again), as their jobs make them."""
    weighing = study(made)
    names = (weighing.candidates * (1 + count // len(weighing.candidates)))[:count]
    found = [weighing.weigh(()), *(weighing.weigh((name,)) for name in names)]
    (folder / "found.pkl").write_bytes(pickle.dumps(found[: 1 + len(weighing.candidates)]))


def verdict(folder: Path, made: SimulatedTable) -> None:
    """Pairs and diagnosis.json."""
    weighing = study(made)
    conclude(
        weighing, with_pairs(weighing, pickle.loads((folder / "found.pkl").read_bytes()), PAIRS)
    )  # our own file


def measured(work: Callable[[], None]) -> dict[str, float]:
    """Seconds and MiB of ``work`` in a fresh process."""
    context = get_context("spawn")
    results = context.Queue()
    process = context.Process(target=_run, args=(work, results))
    process.start()
    found: dict[str, float] | Exception = results.get()
    process.join()
    if isinstance(found, Exception):
        raise found
    return found


def _run(work: Callable[[], None], results: Any) -> None:
    wall, cpu = time.perf_counter(), time.process_time()
    try:
        work()
    except Exception as error:  # a parent that waits must hear of it
        results.put(error)
        return
    # not getrusage's: that one remembers the parent's peak across exec
    (peak,) = (
        line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM")
    )
    results.put({
        "wall_s": round(time.perf_counter() - wall, 2), "cpu_s": round(time.process_time() - cpu, 2),
        "mib": round(int(peak.split()[1]) / 1024),
    })  # fmt: skip


def exponents_of(rows: Mapping[int, Mapping[str, float]]) -> list[float]:
    """Slopes of log processor time over log size from each size to the next."""
    seconds = np.maximum([row["cpu_s"] for row in rows.values()], 1e-3)
    slopes = np.diff(np.log(seconds)) / np.diff(np.log(list(rows)))
    return [round(float(slope), 2) for slope in slopes]


def draw(by_runs: Mapping[str, Mapping[int, Mapping[str, float]]], path: Path) -> None:
    """Processor time and memory over the number of runs."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    for axis, key, label in zip(
        axes, ("cpu_s", "mib"), ("processor time [s]", "peak memory [MiB]"), strict=True
    ):
        for marker, (stage, found) in zip("os^vDPX", by_runs.items(), strict=False):
            axis.loglog(list(found), [row[key] for row in found.values()], marker=marker, label=stage)
        axis.set(xlabel="runs", ylabel=label)
        axis.grid(alpha=0.3)
    axes[1].set(yscale="linear", ylim=(0, None))
    axes[1].axhline(1024, color="0.4", linestyle=":")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right upper", fontsize=8)
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, nargs="+", default=[60, 600, 6000])
    parser.add_argument("--candidates", type=int, nargs="+", default=[4, 16, 64])
    parser.add_argument("--picture", type=Path, help="file to draw to")
    parser.add_argument("--only", help="a stage, after the posteriors: recorded as growth_<stage>.json")
    chosen = parser.parse_args()
    by_runs: dict[str, dict[int, dict[str, float]]] = {}
    by_candidates: dict[int, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as name:
        for number, runs in enumerate(
            [chosen.runs[0], *chosen.runs]
        ):  # the first pass compiles and does not count
            folder = Path(name) / f"{number}_{runs}"
            folder.mkdir()
            made = campaign(runs)
            jobs = {stage: partial(posterior, folder, made, stage) for stage in STAGES}
            jobs |= {
                "predictions": partial(prediction, folder, made),
                "16 candidates": partial(candidate, folder, made, 16),
                "verdict": partial(verdict, folder, made),
            }
            if chosen.only:
                jobs = {stage: work for stage, work in jobs.items() if stage in (*STAGES, chosen.only)}
            for stage, work in jobs.items():
                by_runs.setdefault(stage, {})[runs] = measured(work)
                print(runs, stage, by_runs[stage][runs], flush=True)
        made = campaign(chosen.runs[0])
        for count in () if chosen.only else chosen.candidates:
            by_candidates[count] = measured(partial(candidate, Path(name), made, count))
            print(count, "candidates", by_candidates[count], flush=True)
    exponents = {stage: exponents_of(rows) for stage, rows in by_runs.items()}
    growth = exponents_of(by_candidates) if by_candidates else []
    print("exponents over runs", exponents)
    print("exponents over candidates", growth)
    if chosen.picture:
        draw(by_runs, chosen.picture)
    sizes, counts = (" ".join(map(str, numbers)) for numbers in (chosen.runs, chosen.candidates))
    command = f"python benchmarks/growth.py --runs {sizes} "
    command += f"--only {chosen.only}" if chosen.only else f"--candidates {counts}"
    record(f"growth_{chosen.only}" if chosen.only else "growth", command, {
        "by_runs": by_runs, "by_candidates": by_candidates,
        "exponents_over_runs": exponents, "exponents_over_candidates": growth,
    })  # fmt: skip


if __name__ == "__main__":
    main()

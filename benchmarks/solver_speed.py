"""How fast: CPU time a simulation, ratios to scipy on the same draws, the big batch, and the scaling plot.

    python benchmarks/solver_speed.py --record

prints a table; --record writes docs/measurements/solver_speed.json and docs/images/solver_scaling.png.
CPU time of this process is what counts, so that a busy machine does not change the figures much.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import solver_plain as plain
import solver_reference as reference
from measurement import record
from solver_draws import draws

from eaclutch.physics.kernels.batch import RESULTS, STATUSES, simulate_share
from eaclutch.physics.kernels.compiled import threads
from eaclutch.physics.kernels.ramp import driven_run
from eaclutch.physics.kernels.statics import driven_gap, rest_before
from eaclutch.physics.model import TOLERANCE
from eaclutch.physics.tables import tables

IMAGE = Path(__file__).resolve().parents[1] / "docs" / "images" / "solver_scaling.png"


def cpu_time(action: Callable[[], object], repeats: int = 3) -> float:
    """Least CPU time [s] of ``repeats`` calls."""
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        action()
        best = min(best, time.process_time() - start)
    return best


def ours(rows: np.ndarray, engage: bool, release: bool, tolerance: float = TOLERANCE) -> float:
    """CPU time [us] a simulation on one core."""
    out, status = np.empty((len(rows), len(RESULTS))), np.empty((len(rows), len(STATUSES)), np.int8)
    seconds = cpu_time(
        lambda: simulate_share(rows, 0, 1, tables(), engage, release, 0.005, tolerance, out, status)
    )
    return seconds / len(rows) * 1e6


def scipy_times(rows: np.ndarray) -> dict[str, float]:
    """CPU time [us] of scipy: LSODA on our tables at rtol 1e-5, and the plain transcription."""
    few, fewer = rows[:40], rows[:4]
    table = tables()
    for row in few[:1]:  # compiled right-hand sides
        reference.engagement(row, 0.005, "LSODA", 1e-5, table)
        reference.release(row, "LSODA", 1e-5, table)
    lsoda_e = cpu_time(
        lambda: [reference.engagement(row, 0.005, "LSODA", 1e-5, table) for row in few], 1
    ) / len(few)
    lsoda_r = cpu_time(lambda: [reference.release(row, "LSODA", 1e-5, table) for row in few], 1) / len(few)
    rests = []
    for row in fewer:
        preload, before = rest_before(row, table)
        _, driven = driven_gap(row, preload, before, table)
        rests.append(
            (
                row,
                plain.step_response(row),
                preload,
                before,
                driven,
                driven_run(row, driven, before, table)[2],
            )
        )
    plain_e = cpu_time(lambda: [plain.engagement(row, e, p, b, d) for row, e, p, b, d, _ in rests], 1) / len(
        fewer
    )
    plain_r = cpu_time(lambda: [plain.release(row, e, p, d, f) for row, e, p, _, d, f in rests], 1) / len(
        fewer
    )
    return {"lsoda_engagement": lsoda_e * 1e6, "lsoda_release": lsoda_r * 1e6,
            "plain_engagement": plain_e * 1e6, "plain_release": plain_r * 1e6}  # fmt: skip


def big_batch(draws_count: int = 1000, runs: int = 311) -> dict[str, float]:
    """311 runs x 1000 draws, engagement and release, through the public predict on all cores."""
    model, conditions, parameters = draws(runs)
    rng = np.random.default_rng(1)
    many = {name: value * rng.normal(1.0, 0.02, (draws_count, 1)) for name, value in parameters.items()}
    many["slip_phase"] = np.clip(many["slip_phase"], 0.0, 1.0)
    wanted = ["engagement_time_s", "release_time_10_s", "release_time_50_s", "release_time_90_s"]
    model.predict(conditions, {}, wanted)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    cpu, wall = time.process_time(), time.perf_counter()
    model.predict(conditions, many, wanted)
    return {
        "simulations": float(runs * draws_count), "cpu_s": time.process_time() - cpu,
        "wall_s": time.perf_counter() - wall, "cores": float(threads()),
        "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, "before_mib": before / 1024,
    }  # fmt: skip


def scaling(rows: np.ndarray) -> dict[str, list[list[float]]]:
    """Cost [us] against batch size, and against the error reached (tolerances 1e-3 .. 1e-7 against 1e-9)."""
    model, conditions, parameters = draws(512)
    wanted = ["engagement_time_s", "release_time_90_s"]
    sizes = []
    for n in (1, 4, 16, 64, 256, 1024, 4096, 16384):
        runs, repeats = min(n, 512), max(1, n // 512)
        part = {name: np.repeat(value[:, :runs], repeats, axis=0) for name, value in parameters.items()}
        some = conditions.select(np.arange(runs))
        model.predict(some, part, wanted)
        sizes.append([float(n), cpu_time(lambda s=some, p=part: model.predict(s, p, wanted), 5) / n * 1e6])  # type: ignore[misc]
    n = len(rows)
    exact, status = np.empty((n, len(RESULTS))), np.empty((n, len(STATUSES)), np.int8)
    simulate_share(rows, 0, 1, tables(), True, True, 0.005, 1e-9, exact, status)
    accuracy = []
    for tolerance in (1e-3, 3e-4, 1e-4, 3e-5, TOLERANCE, 1e-5, 1e-6, 1e-7):
        out = np.empty_like(exact)
        simulate_share(rows, 0, 1, tables(), True, True, 0.005, tolerance, out, status)
        errors = [np.nanquantile(np.abs(out[:, c] / exact[:, c] - 1), 0.99) for c in (9, 12)]
        accuracy.append(
            [
                tolerance,
                *map(float, errors),
                ours(rows, True, False, tolerance),
                ours(rows, False, True, tolerance),
            ]
        )
    return {"size_us": sizes, "tolerance_q99_engagement_release_us_engagement_release": accuracy}


def draw_plot(found: dict[str, list[list[float]]], target: Path) -> None:
    """Two panels: cost a simulation against batch size and against accuracy."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    size = np.array(found["size_us"])
    left.loglog(size[:, 0], size[:, 1], "o-")
    left.set(
        xlabel="simulations in a batch",
        ylabel="CPU time a simulation [us]",
        title="predict: engagement and release",
    )
    a = np.array(found["tolerance_q99_engagement_release_us_engagement_release"])
    right.loglog(a[:, 1], a[:, 3], "o-", label="engagement")
    right.loglog(a[:, 2], a[:, 4], "s-", label="release")
    right.set(xlabel="relative error of the time, 99 % of draws below", ylabel="CPU time a simulation [us]")
    right.legend(frameon=False)
    right.set_ylim(1.0, 100.0)
    right.set_title("solver alone, one core")
    target.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(target, dpi=120, metadata={"Software": None})


def main() -> None:
    """Measure, print, record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=2000)
    parser.add_argument("--record", action="store_true")
    options = parser.parse_args()
    start = time.perf_counter()
    model, conditions, parameters = draws(options.draws)
    rows = model.rows(conditions, parameters)[0].reshape(-1)
    ours(rows[:4], True, True)
    ready = time.perf_counter() - start
    steady = ours(rows, False, False)
    engagement, release = ours(rows, True, False) - steady, ours(rows, False, True) - steady
    slipping = float(
        np.mean(model.predict(conditions, parameters, ["release_time_90_s"]).status["release"] == 0)
    )
    scipy = scipy_times(rows)
    values: dict[str, object] = {
        "draws": options.draws, "tolerance": TOLERANCE, "share_that_slips": slipping,
        "us": {"steady_gap_and_capacity": steady, "engagement": engagement, "release": release,
               "release_of_those_that_slip": release / slipping, **scipy},
        "ratio": {"lsoda_engagement": scipy["lsoda_engagement"] / engagement,
                  "lsoda_release": scipy["lsoda_release"] / release,
                  "plain_engagement": scipy["plain_engagement"] / engagement,
                  "plain_release": scipy["plain_release"] / release},
        "first_use_s": ready, "batch": big_batch(),
    }  # fmt: skip
    for group in ("us", "ratio", "batch"):
        for name, value in values[group].items():  # type: ignore[attr-defined]
            print(f"{group:<6} {name:<28} {value:12.2f}")
    print(f"first use (tables, compilation or its cache) {ready:.1f} s; {slipping:.0%} of the draws slip")
    if options.record:
        found = scaling(rows)
        draw_plot(found, IMAGE)
        record("solver_speed", "python benchmarks/solver_speed.py --record", values | {"scaling": found})


if __name__ == "__main__":
    main()

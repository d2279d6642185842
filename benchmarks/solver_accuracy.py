"""How right: our engagement and release times against scipy's Radau at rtol 1e-10 on the unreduced equations.

    python benchmarks/solver_accuracy.py --draws 2000

prints a table and records it in docs/measurements/solver_accuracy.json. The reference takes about 0.3 s a draw; it
is kept in --keep (a .npz), so that a second look at other tolerances is quick.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
import solver_reference as reference
from measurement import record
from solver_draws import draws
from tqdm import tqdm

from eaclutch.physics.model import TOLERANCE, ClutchModel
from eaclutch.physics.prediction import Status

RESULTS = ("release_time_10_s", "release_time_50_s", "release_time_90_s", "final_force_n")
TIMES = ("engagement_time_s", *RESULTS[:3])


def solve_reference(number: int, rtol: float, keep: Path | None, until: float) -> dict[str, np.ndarray]:
    """Reference times and statuses of the draws, (draws,) each; resumed from ``keep``. Draws not reached within
    ``until`` seconds stay not-a-number."""
    deadline = time.monotonic() + until
    model, conditions, parameters = draws(number)
    rows = model.rows(conditions, parameters)[0][0]
    found = np.full((number, 6), np.nan)
    if keep is not None and keep.exists():
        with np.load(keep) as stored:
            if int(stored["draws"]) == number and float(stored["rtol"]) == rtol:
                found = stored["found"]
    for i in tqdm(np.flatnonzero(np.isnan(found[:, 0])), disable=None):
        status, results = reference.release(rows[i], "Radau", rtol)
        found[i] = (status, reference.engagement(rows[i], 0.005, "Radau", rtol), *results)
        if time.monotonic() > deadline:
            break
        if keep is not None and i % 20 == 19:
            np.savez(keep, draws=number, rtol=rtol, found=found)
    if keep is not None:
        np.savez(keep, draws=number, rtol=rtol, found=found)
    return {name: found[:, i] for i, name in enumerate(("status", "engagement_time_s", *RESULTS))}


def compare(number: int, exact: dict[str, np.ndarray], tolerance: float) -> dict[str, object]:
    """Quantiles of the relative errors, shares within 1e-3 and 1e-4, statuses that differ, NaN where ok."""
    model, conditions, parameters = draws(number)
    model = ClutchModel(model.bench, model.effects, tolerance=tolerance)
    p = model.predict(conditions, parameters)
    solved = np.isfinite(exact["status"])
    ok = solved & (exact["status"] == Status.ok) & (p.status["release"][0] == Status.ok)
    out: dict[str, object] = {
        "statuses_that_differ": int(np.sum((exact["status"] != p.status["release"][0])[solved])),
        "not_a_number_where_ok": int(
            sum(np.isnan(p.values[n][p.status_of(n) == Status.ok]).sum() for n in p.values)
        ),
    }
    for name in TIMES:
        chosen = solved if name == "engagement_time_s" else ok
        error = np.abs(p.values[name][0, chosen] / exact[name][chosen] - 1)
        out[name] = {
            "median": float(np.median(error)), "q99": float(np.quantile(error, 0.99)),
            "q999": float(np.quantile(error, 0.999)), "largest": float(error.max()),
            "share_within_1e-3": float(np.mean(error < 1e-3)), "share_within_1e-4": float(np.mean(error < 1e-4)),
        }  # fmt: skip
    return out


def main() -> None:
    """Solve, compare, print, record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=2000)
    parser.add_argument("--rtol", type=float, default=1e-10)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--until", type=float, default=np.inf, help="seconds to spend on the reference")
    parser.add_argument("--record", action="store_true", help="write docs/measurements/solver_accuracy.json")
    options = parser.parse_args()
    exact = solve_reference(options.draws, options.rtol, options.keep, options.until)
    solved = int(np.isfinite(exact["status"]).sum())
    table = {f"{t:g}": compare(options.draws, exact, t) for t in (1e-4, TOLERANCE, 1e-6)}
    print(f"{solved} draws against Radau at rtol {options.rtol:g}; default tolerance {TOLERANCE:g}")
    heads = ("median", "99 %", "99.9 %", "largest", "<1e-3", "<1e-4")
    print(f"{'tolerance':>9} {'observable':<19} " + " ".join(f"{head:>8}" for head in heads))
    for tolerance, row in table.items():
        for name in TIMES:
            e = row[name]
            print(f"{tolerance:>9} {name:<19} {e['median']:8.1e} {e['q99']:8.1e} {e['q999']:8.1e} {e['largest']:8.1e} "
                  f"{e['share_within_1e-3']:8.2%} {e['share_within_1e-4']:8.2%}")  # fmt: skip
        print(
            f"{tolerance:>9} statuses that differ {row['statuses_that_differ']}, NaN {row['not_a_number_where_ok']}"
        )
    if options.record:
        record("solver_accuracy", f"python benchmarks/solver_accuracy.py --draws {options.draws} --record",
               {"draws": solved, "reference_rtol": options.rtol, "by_tolerance": table})  # fmt: skip


if __name__ == "__main__":
    main()

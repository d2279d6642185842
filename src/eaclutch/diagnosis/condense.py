"""A campaign that is larger than its data vector may be: sessions are taken together, rare conditions left out.

Every hypothesis solves with matrices of (entries, entries), so the number of entries bounds memory and time, however
many runs a lab captures; more runs then make each entry surer instead of adding entries.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

MOST_ENTRIES = 1500  # of runs: matrices of 18 MB
FEWEST_SESSIONS = 3


def condense(table: pd.DataFrame, channels: int) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """``table`` (rows of runs.csv) with at most MOST_ENTRIES / ``channels`` groups of (condition, session), and what
    was done to get there.

    Where there are more, consecutive sessions become one, as few as needed: what they differ by then counts as scatter
    between repeats. Where there are so many conditions that fewer than FEWEST_SESSIONS would be left, those with the
    fewest runs are left out: without sessions nothing can be said of what drifts from one to the next.
    """
    most = max(1, MOST_ENTRIES // max(1, channels))
    if _groups(table["condition"], table["session"]) <= most:
        return table, ()
    notes = []
    runs = table["condition"].value_counts(sort=True, ascending=False)
    kept = max(1, most // min(FEWEST_SESSIONS, table["session"].nunique()))
    if len(runs) > kept:
        table = table[table["condition"].isin(runs.index[:kept])].reset_index(drop=True)
        notes.append(f"the {len(runs) - kept} of {len(runs)} conditions with the fewest runs are left out")
    sessions = list(dict.fromkeys(table.sort_values("run")["session"].astype(str)))
    for count in range(len(sessions), 0, -1):
        blocks = np.array_split(np.array(sessions, dtype=object), count)
        names = {name: _name(block) for block in blocks for name in block}
        together = table["session"].astype(str).map(names)
        if _groups(table["condition"], together) <= most:
            break
    if count < len(sessions):
        notes.append(
            f"{len(sessions)} sessions are taken together as {count}: what they differ by counts as scatter of repeats"
        )
    order = table.assign(session=together).sort_values("run").groupby("session").cumcount()
    return table.assign(session=together, run_order=order), tuple(notes)


def _groups(conditions: pd.Series, sessions: pd.Series) -> int:
    return len(set(zip(conditions.astype(str), sessions.astype(str), strict=True)))


def _name(block: np.ndarray) -> str:
    return str(block[0]) if len(block) == 1 else f"{block[0]} to {block[-1]}"

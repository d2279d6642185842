"""Work on one study, spread over processes: results come back in the items' order, the same for any number of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context
from types import TracebackType
from typing import TypeVar

from eaclutch.diagnosis.study import Study

Item = TypeVar("Item")
Result = TypeVar("Result")

_held: list[Study] = []  # of a worker process


class Spread:
    """``spread(work, items)`` is ``[work(study, item) for item in items]``, in ``jobs`` processes.

    A context: its processes are started when first needed and end with it. ``work`` is a function of a module.
    """

    def __init__(self, study: Study, jobs: int = 1):
        self.study, self.jobs = study, jobs
        self._pool: ProcessPoolExecutor | None = None

    def __call__(self, work: Callable[[Study, Item], Result], items: Iterable[Item]) -> list[Result]:
        items = list(items)
        if self.jobs < 2 or len(items) < 2:
            return [work(self.study, item) for item in items]
        if self._pool is None:
            # not forked: a lock that another thread of this process holds would stay shut in the copy
            self._pool = ProcessPoolExecutor(self.jobs, get_context("spawn"), _hold, (self.study,))
        return list(self._pool.map(_apply, repeat(work), items))

    def __enter__(self) -> Spread:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)


def _hold(study: Study) -> None:
    _held[:] = [study]


def _apply(work: Callable[[Study, Item], Result], item: Item) -> Result:
    return work(_held[0], item)

"""Fewer constants to move: a frame of the base model costs a solve of all runs for each of them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from eaclutch.blind import truth


@pytest.fixture(scope="module")
def few_constants() -> Iterator[None]:
    """One constant in front of the film and two behind it."""
    chosen = ("contact_stiffness", "stiffness", "film_static")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(truth, "MOVABLE", {name: truth.MOVABLE[name] for name in chosen})
        yield

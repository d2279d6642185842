"""Fewer constants to move: a frame of the base model costs a solve of all runs for each of them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from eaclutch.blind import frame


@pytest.fixture(scope="module")
def few_constants() -> Iterator[None]:
    """One constant in front of the film, two behind it and one of the bench."""
    chosen = ("contact_stiffness", "stiffness", "film_static", "stray_capacitance")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(frame, "MOVABLE", {name: frame.MOVABLE[name] for name in chosen})
        yield

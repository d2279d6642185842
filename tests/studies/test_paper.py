"""The paper's model numbers with its own parameters."""

from __future__ import annotations

import numpy as np
import pytest

from eaclutch.config import load_bench
from eaclutch.studies.paper import preset_claims, step_response


@pytest.fixture(scope="module")
def claims(tmp_path_factory: pytest.TempPathFactory) -> dict:
    folder = tmp_path_factory.mktemp("published-bench")
    (folder / "campaign.yaml").write_text("")  # an empty file means the published bench
    return {claim.name: claim for claim in preset_claims(load_bench(folder), 0.8)}


@pytest.mark.parametrize(
    ("name", "within"),
    [
        ("-3 dB bandwidth of the capacity", 0.08),
        ("release over voltage, model slope", 0.2),
        ("release over width, model slope", 0.2),
        ("rough over flat force at a gap of one roughness", 0.03),
        ("polarisation 100 us after a step", 0.005),
    ],
)
def test_each_comes_near_the_printed_number(claims: dict, name: str, within: float) -> None:
    assert claims[name].ratio == pytest.approx(1.0, abs=within)


def test_a_step_response_starts_at_nothing_and_ends_at_all() -> None:
    share = step_response(np.array([1e-12, 1.0]))["share"]
    assert share.iloc[0] == pytest.approx(0.0, abs=1e-3) and share.iloc[1] == pytest.approx(1.0, abs=1e-3)

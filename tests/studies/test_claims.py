"""Side computations against numbers worked out apart from the code."""

import pytest

from eaclutch.studies.claims import LITERATURE_TIMES, maxwell_wagner_time, side_claims


def test_maxwell_wagner_time_by_hand():
    # 8.854188e-12 * (50e-6 + 24e-6) / (1e-17 + 1.2e-20)
    assert maxwell_wagner_time(50.0, 1e-11, 24e-6, 1e-6) == pytest.approx(65.4424, rel=1e-5)


def test_polyimide_claim_does_not_follow_and_says_so():
    claims = {claim.name: claim for claim in side_claims()}
    polyimide = claims["Maxwell-Wagner time, polyimide, 1 um gap"]
    assert polyimide.ratio < 0.6
    assert "does not follow" in polyimide.note
    for name in ("Maxwell-Wagner time, 1 um gap", "Maxwell-Wagner time, 10 um gap"):
        assert claims[name].ratio == pytest.approx(1.0, abs=5e-3)


def test_parallel_plate_pad_is_reproduced_with_the_stated_assumption():
    claims = {claim.name: claim for claim in side_claims()}
    assert claims["parallel-plate pad, 0.76 nF/cm2: air gap"].ratio == pytest.approx(1.0, abs=0.01)
    assert claims["parallel-plate pad at 150 V: shear capacity"].ratio == pytest.approx(1.0, abs=0.01)


def test_no_published_time_is_missing():
    assert len(LITERATURE_TIMES) == 21

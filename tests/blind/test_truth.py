"""What is true of a case: shares of the gap, distances, places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from eaclutch.blind.case import build_case
from eaclutch.blind.frame import Frame, frame_of, scaled_features
from eaclutch.blind.plan import Entry
from eaclutch.blind.truth import truth_of


def case(*effects: tuple[str, float]):  # type: ignore[no-untyped-def]
    return build_case(Entry("truth", "test", 8, "pair" if len(effects) == 2 else "single", effects))


pytestmark = pytest.mark.usefixtures("few_constants")


@pytest.fixture(scope="module")
def frame(few_constants: None) -> Frame:
    return frame_of(case())


def test_constants_explain_what_they_cause_and_no_more() -> None:
    tangent = np.array([[3.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    frame = Frame(np.zeros(3), np.ones(3), tangent, constants=1)
    np.testing.assert_allclose(frame.left(np.array([10.0, 2.0, 0.0])), [1.0, 2.0, 0.0])
    # whitened by 1 + J J': the first entry counts 10 / sqrt(10)
    assert frame.distance(np.array([10.0, 2.0, 0.0])) == pytest.approx(np.sqrt(10.0 + 4.0))


def test_the_base_model_has_no_distance_from_itself(frame: Frame) -> None:
    plain = case()
    shift = frame.shift(scaled_features(plain, (), plain.constants))
    assert frame.distance(shift) == pytest.approx(0.0, abs=1e-6)


def test_a_larger_effect_lies_farther_away(frame: Frame) -> None:
    found = []
    for size in (0.3, 1.0, 3.0):
        latency = case(("trigger_latency", size))
        found.append(
            frame.distance(frame.shift(scaled_features(latency, ("trigger_latency",), latency.constants)))
        )
    assert found[0] < found[1] < found[2]


def test_shares_of_a_pair_and_the_place_of_the_gap() -> None:
    truth = truth_of(case(("trigger_latency", 1.0), ("slow_stage", 1.0)))
    assert truth["closure"]["slow_stage+trigger_latency"] == pytest.approx(1.0)
    assert 0.0 < truth["closure"]["trigger_latency"] < 1.0
    shares = {row["observable"]: row["share"] for row in truth["where"]}
    # the stiffness takes up a slow stage's ramp, and the release pays for it: the gap is seen there
    assert max(shares, key=lambda name: shares[name]).startswith("release_time")
    assert sum(shares.values()) <= 1.0 + 1e-9
    assert truth["distance_calibrated"] <= truth["distance"]


def test_calibration_follows_the_fixtures_stray_capacitance(frame: Frame) -> None:
    plain = case()
    other = replace(plain.constants, stray_capacitance=plain.constants.stray_capacitance + 3e-13)
    shift = frame.shift(scaled_features(plain, (), other))
    assert np.linalg.norm(frame.left(shift)) < 0.5 * np.linalg.norm(shift)

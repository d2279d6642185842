"""Simulation-based calibration: passes a right posterior, catches a wrong one, and works on a real stage."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from eaclutch.inference.calibration import DRAWS, Replicable, replications, verdict
from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.posterior import StageInputs
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem
from eaclutch.inference.replicable import replicable
from eaclutch.inference.sampling import SamplerSettings
from eaclutch.inference.stages.load_cell import swing
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.physics.parameters import base_parameters
from eaclutch.records import Bench, BurstFeatures, InputError

QUICK = SamplerSettings(ensembles=2, walkers=12, check_every=60, max_steps=60, warm_up=60)
PARAMETERS = dict(HYPERPARAMETERS) | base_parameters(Bench("x"), "linear")


def normal_case(believed_sd: float) -> Replicable:
    """Ten readings of a mean with noise of sd 1; the likelihood believes ``believed_sd``."""
    priors = Priors.of([Parameter("mean", "1", (-np.inf, np.inf), 0.0, Prior("normal", 0.0, 2.0))])

    def build(observed):
        def pointwise(theta):
            gap = (observed - theta) / believed_sd
            return -0.5 * gap**2 - np.log(believed_sd)

        return Problem(
            "made", priors, lambda theta: pointwise(theta).sum(axis=1), pointwise,
            lambda theta, rng, posterior=True: theta + rng.standard_normal((len(theta), 10)), observed,
        )  # fmt: skip

    return Replicable(build(np.zeros(10)), build)


def test_verdicts_on_known_ranks():
    rng = np.random.default_rng(0)
    good = {name: rng.integers(0, DRAWS + 1, 200) for name in "abcd"}
    assert verdict(good, rng)["passed"]
    shifted = verdict(good | {"b": np.minimum(good["b"] + 20, DRAWS)}, rng)
    assert not shifted["passed"] and not shifted["parameters"]["b"]["inside_band"]
    narrow = rng.choice([0, 1, 2, 97, 98, 99, *range(3, 97)], 200, p=[0.08] * 6 + [0.52 / 94] * 94)
    row = verdict(good | {"c": narrow}, rng)["parameters"]["c"]
    assert row["coverage_high"] < 0.9  # overconfident


@pytest.mark.parametrize(("believed_sd", "right"), [(1.0, True), (0.4, False)])
def test_wrong_noise_is_caught(believed_sd, right):
    found = replications(normal_case(believed_sd), QUICK, 3, range(40))
    row = verdict(found["ranks"], np.random.default_rng(0))["parameters"]["mean"]
    assert row["inside_band"] == right
    assert (row["coverage_low"] <= 0.9 <= row["coverage_high"]) == right


def test_parts_join_to_the_whole():
    case = normal_case(1.0)
    whole = replications(case, QUICK, 5, range(4))["ranks"]["mean"]
    parts = [replications(case, QUICK, 5, range(part, 4, 2))["ranks"]["mean"] for part in (0, 1)]
    assert [parts[0][0], parts[1][0], parts[0][1], parts[1][1]] == whole


def test_load_cell_stage_is_calibrated_in_small():
    rng = np.random.default_rng(1)
    frequency, ratio = swing(18018.0, 0.0011, 0.43)
    made = BurstFeatures(np.full(8, frequency), np.ones(8), np.full(8, ratio), np.full(8, 0.003))
    inputs = StageInputs(Bench("x"), PARAMETERS, bursts=made)
    case = replicable("load_cell", inputs, rng)
    found = replications(case, replace(QUICK, walkers=20), 2, range(12))
    result = verdict(found["ranks"], rng)
    assert result["passed"] and set(result["parameters"]) == set(case.problem.priors.names)
    with pytest.raises(InputError, match="no data whose layout"):
        replicable("contact", replace(inputs, bursts=None), rng)

"""Priors: the map to standard normals, its inverse, the density, and errors that name the key."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from eaclutch.inference.priors import Priors
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.records import InputError

CASES = {
    "normal": (Prior("normal", 2.0, 0.5), (-np.inf, np.inf), stats.norm(2, 0.5)),
    "cut normal": (Prior("normal", 1.0, 1.0), (0.0, 3.0), stats.truncnorm(-1, 2, 1, 1)),
    "upper tail": (Prior("normal", 0.0, 1.0), (2.0, 5.0), stats.truncnorm(2, 5)),
    "lognormal": (Prior("lognormal", 3.0, 0.7), (0.0, np.inf), stats.lognorm(0.7, scale=3)),
    "halfnormal": (Prior("halfnormal", 2.0), (0.0, np.inf), stats.halfnorm(scale=2)),
    "uniform": (Prior("uniform", -1.0, 4.0), (-1.0, 4.0), stats.uniform(-1, 5)),
    "loguniform": (Prior("loguniform", 1e-3, 10.0), (1e-3, 10.0), stats.loguniform(1e-3, 10)),
}


def priors(name: str) -> Priors:
    prior, bounds, _ = CASES[name]
    return Priors.of([Parameter("x", "1", bounds, 1.0, prior)])


@pytest.mark.parametrize("name", CASES)
def test_map_and_density_agree_with_scipy(name):
    set_, reference = priors(name), CASES[name][2]
    p = np.linspace(0.001, 0.999, 41)
    theta = set_.from_normal(stats.norm.ppf(p)[:, None])[:, 0]
    np.testing.assert_allclose(theta, reference.ppf(p), rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(set_.log_density(theta[:, None]), reference.logpdf(theta), atol=1e-8)
    assert set_.sd()[0] == pytest.approx(reference.std(), rel=2e-3)


@settings(deadline=None, max_examples=40)
@given(st.sampled_from(sorted(CASES)), st.floats(-4, 4))
def test_there_and_back(name, u):
    set_ = priors(name)
    back = set_.to_normal(set_.from_normal(np.array([[u]])))
    assert back[0, 0] == pytest.approx(u, abs=1e-5)


def test_draws_follow_the_prior():
    draws = priors("cut normal").sample(np.random.default_rng(0), 4000)[:, 0]
    assert stats.kstest(draws, CASES["cut normal"][2].cdf).pvalue > 0.01


@pytest.mark.parametrize(
    ("prior", "bounds"),
    [
        (Prior("normal", 0.0, -1.0), (-1.0, 1.0)),
        (Prior("lognormal", -1.0, 1.0), (0.0, 1.0)),
        (Prior("uniform", 3.0, 1.0), (0.0, 4.0)),
        (Prior("normal", 0.0, 1.0), (50.0, 60.0)),
        (Prior("normal", 0.0, 1.0), (1.0, 1.0)),
    ],
)
def test_impossible_priors_name_their_key(prior, bounds):
    with pytest.raises(InputError, match=r"priors\.contact_stiffness"):
        Priors.of([Parameter("contact_stiffness", "1", bounds, 1.0, prior)])

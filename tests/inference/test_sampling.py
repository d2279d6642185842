"""Sampling: right on a known posterior, extended by itself, the same bit for bit, resumed only where it may be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from eaclutch.inference.convergence import Thresholds
from eaclutch.inference.priors import Priors
from eaclutch.inference.problem import Problem, digest
from eaclutch.inference.sampling import SamplerSettings, sample
from eaclutch.inference.start import starting_walkers
from eaclutch.physics.effect import Parameter, Prior
from eaclutch.records import InputError

QUICK = SamplerSettings(ensembles=4, walkers=12, check_every=150, max_steps=3000, warm_up=100)


def gaussian(size=3, seed=0, **fingerprint) -> tuple[Problem, np.ndarray, np.ndarray]:
    """A correlated Gaussian likelihood times standard normal priors: mean and covariance are known."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((size, size)) * 4
    precision, centre = root @ root.T, rng.standard_normal(size)
    names = [f"p{i}" for i in range(size)]
    priors = Priors.of([Parameter(n, "1", (-np.inf, np.inf), 0.0, Prior("normal", 0.0, 1.0)) for n in names])

    def log_likelihood(theta):
        return -0.5 * np.einsum("ni,ij,nj->n", theta - centre, precision, theta - centre)

    covariance = np.linalg.inv(precision + np.eye(size))
    marks = {"data": digest([centre]), "code": "1"} | fingerprint
    return (
        Problem("test", priors, log_likelihood, fingerprint=marks),
        covariance @ precision @ centre,
        covariance,
    )


def test_moments_of_a_known_posterior():
    problem, mean, covariance = gaussian()
    found = sample(problem, replace(QUICK, walkers=24), 1)
    sd = np.sqrt(np.diag(covariance))
    assert found.converged and not found.failures
    np.testing.assert_allclose(found.flat.mean(axis=0), mean, atol=0.04 * sd.max())
    # emcee's snooker move would be 10 to 25 % off here
    np.testing.assert_allclose(found.flat.std(axis=0), sd, rtol=0.03)
    np.testing.assert_allclose(np.corrcoef(found.flat.T), covariance / np.outer(sd, sd), atol=0.03)


def test_a_parameter_of_several_modes_is_redrawn_from_mode_to_mode():
    problem, *_ = gaussian(size=6)
    others, sd = problem.log_likelihood, 0.03
    modes, share = np.array([-0.5, 1.0]), np.array([0.7, 0.3])

    def log_likelihood(theta):  # the first parameter's posterior: two narrow modes, of the given shares
        white = (theta[:, :1] - modes) / sd
        weight = np.log(share) + 0.5 * modes**2  # the prior taken off
        return others(theta * (np.arange(6) > 0)) + np.logaddexp(*(weight - 0.5 * white**2).T)

    several = replace(problem, log_likelihood=log_likelihood, redrawn=("p0",))
    brief = replace(QUICK, max_steps=600)
    stuck, found = (sample(p, brief, 1) for p in (replace(several, redrawn=()), several))
    low = [np.mean(run.chain[..., 0] < 0.25, axis=(1, 2)) for run in (stuck, found)]  # (ensembles,)
    assert np.max(np.abs(low[0] - 0.7)) > 0.2, "else this test tests nothing"
    np.testing.assert_allclose(low[1], 0.7, atol=0.05)
    np.testing.assert_allclose(found.flat[:, 1:].std(axis=0), stuck.flat[:, 1:].std(axis=0), rtol=0.1)
    assert np.max(found.diagnostics.tau[1:]) < 8, "the others jump with that one held: 33 steps without"
    assert np.max(found.diagnostics.r_hat) < 1.05


def test_goes_on_until_converged_or_says_so():
    problem, *_ = gaussian()
    long = sample(problem, QUICK, 1)
    short = sample(problem, replace(QUICK, max_steps=20, check_every=20), 1)
    assert long.converged and long.total_steps > 150
    assert not short.converged and short.failures and short.total_steps <= 21
    harder = replace(QUICK, thresholds=Thresholds(ess=20000))
    assert sample(problem, harder, 1).total_steps > long.total_steps


def test_an_ensemble_whose_search_failed_starts_at_the_best_mode():
    priors = Priors.of([Parameter("x", "1", (-np.inf, np.inf), 0.0, Prior("normal", 0.0, 1.0))])

    def log_likelihood(theta):  # a narrow peak at 1 and, 60 nats below, a wide one that most searches end in
        x = theta[:, 0]
        return np.logaddexp(-0.5 * ((x - 1) / 0.0003) ** 2, -60 - 0.5 * ((x + 1) / 0.5) ** 2)

    problem = Problem("two", priors, log_likelihood)
    densities = [starting_walkers(problem.log_density, 1, 8, np.random.default_rng(s)).density
                 for s in np.random.SeedSequence(8).spawn(4)]  # fmt: skip
    assert min(densities) < max(densities) - 50
    found = sample(problem, QUICK, 8)
    assert np.all(np.abs(found.flat - 1) < 0.002)


def test_same_seed_same_bits_other_seed_other():
    problem, *_ = gaussian()
    first, again, other = sample(problem, QUICK, 5), sample(problem, QUICK, 5), sample(problem, QUICK, 6)
    np.testing.assert_array_equal(first.chain, again.chain)
    assert first.chain.shape != other.chain.shape or not np.array_equal(first.chain, other.chain)


class Interrupted(RuntimeError):
    pass


def test_resumes_bit_for_bit(tmp_path):
    problem, *_ = gaussian()
    settings, path = replace(QUICK, thresholds=Thresholds(ess=8000)), tmp_path / "c.npz"
    whole = sample(problem, settings, 3)
    calls = 0

    def until_cut(theta):
        nonlocal calls
        calls += path.exists()
        if calls > 500:  # in the middle of a chunk, some time after the first checkpoint
            raise Interrupted
        return problem.log_likelihood(theta)

    with pytest.raises(Interrupted):
        sample(replace(problem, log_likelihood=until_cut), settings, 3, checkpoint=path)
    lines: list[str] = []
    resumed = sample(problem, settings, 3, checkpoint=path, progress=lines.append)
    assert "resuming" in lines[0]
    assert resumed.evaluations < whole.evaluations
    np.testing.assert_array_equal(resumed.chain, whole.chain)
    np.testing.assert_array_equal(resumed.log_density, whole.log_density)


def test_refuses_to_resume_and_says_what_changed(tmp_path):
    problem, *_ = gaussian()
    path = tmp_path / "c.npz"
    sample(problem, replace(QUICK, max_steps=150), 3, checkpoint=path)
    longer = replace(QUICK, max_steps=300)
    changed = {
        "data": gaussian(data="other")[0],
        "code": gaussian(code="2")[0],
        "parameter order": replace(problem, priors=Priors.of(problem.priors.parameters[::-1])),
    }
    prior = [
        replace(problem.priors.parameters[0], prior=Prior("normal", 0.0, 2.0)),
        *problem.priors.parameters[1:],
    ]
    changed["prior"] = replace(problem, priors=Priors.of(prior))
    for what, other in changed.items():
        with pytest.raises(InputError, match=f": {what} changed since"):
            sample(other, longer, 3, checkpoint=path)
    with pytest.raises(InputError, match="sampler changed"):
        sample(problem, longer, 4, checkpoint=path)
    assert sample(problem, longer, 3, checkpoint=path).total_steps > 150


def test_a_torn_checkpoint_is_an_error(tmp_path):
    problem, *_ = gaussian()
    path = tmp_path / "c.npz"
    path.write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(InputError, match="not a readable checkpoint"):
        sample(problem, QUICK, 3, checkpoint=path)


def test_a_likelihood_that_is_nowhere_finite_is_named():
    problem, *_ = gaussian()
    with pytest.raises(ValueError, match="finite likelihood"):
        sample(replace(problem, log_likelihood=lambda theta: np.full(len(theta), -np.inf)), QUICK, 3)

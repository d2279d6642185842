"""A cloud of signatures stands for its law, in between the scouted ones too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_triangular

from eaclutch.diagnosis import clouds
from eaclutch.diagnosis.clouds import Cloud, cloud_of

ENTRIES = 20


def arc(angle: np.ndarray, size: float) -> np.ndarray:
    """Signatures (angles, entries) of a law that turns from one direction into another, ``size`` sd long."""
    return size * np.outer(np.cos(angle), np.eye(ENTRIES)[0]) + size * np.outer(
        np.sin(angle), np.eye(ENTRIES)[1]
    )


def cloud(size: float) -> Cloud:
    scouted = arc(np.linspace(0.0, np.pi / 2, 9), size)
    return cloud_of(scouted, 0.0, lambda rows: rows, np.eye(ENTRIES))


def plain(a: np.ndarray) -> np.ndarray:
    return -0.5 * np.sum(a**2, axis=1)


def test_what_lies_between_two_scouted_signatures_belongs_to_the_law(monkeypatch):
    """Halfway between two that are ten sd apart, five sd from each."""
    between = arc(np.array([np.pi / 32]), 50.0)
    gained = cloud(50.0).evidence(between) - plain(between)
    assert gained > 0.5 * 50.0**2 - 15.0  # the best that any law could gain, less what its parameters cost
    monkeypatch.setattr(clouds, "NEIGHBOURS", 0)
    assert cloud(50.0).evidence(between) - plain(between) < gained - 3.0


def test_a_law_without_parameters_has_no_neighbours():
    alone = cloud_of(arc(np.zeros(1), 5.0), 0.0, lambda rows: rows, np.eye(ENTRIES))
    assert np.all(np.isfinite(alone.evidence(np.zeros((1, ENTRIES)))))


def test_a_law_is_off_by_its_share_of_what_it_does():
    """Whitened as the data are: by the root of a covariance, from both sides."""
    rng = np.random.default_rng(5)
    root = np.linalg.cholesky(np.cov(rng.standard_normal((ENTRIES, 60))))
    smooth = 0.7 + 0.3 * np.eye(ENTRIES)
    shift = rng.standard_normal((1, ENTRIES))
    made = cloud_of(shift, 0.2, lambda rows: solve_triangular(root, rows.T, lower=True).T, smooth)
    found = made.spread[1][:, 1 : clouds.LAW_DIRECTIONS + 1]  # of amplitude 1
    true = solve_triangular(root, 0.2 * np.diag(shift[0]) @ np.linalg.cholesky(smooth), lower=True)
    widest = np.linalg.svd(true)[1][: clouds.LAW_DIRECTIONS]
    np.testing.assert_allclose(np.sort(np.linalg.norm(found, axis=0))[::-1], widest, rtol=1e-6)


def test_its_evidence_is_a_density():
    """Under no effect a likelihood ratio is one in the mean."""
    a = np.random.default_rng(3).standard_normal((200_000, ENTRIES))
    made = cloud(1.5)
    assert np.mean(np.exp(made.evidence(a) - plain(a))) == pytest.approx(1.0, abs=0.05)

"""A fit is made around a gap of some size, and once more where the gap turns out to be of another; from several starts
at a time."""

from __future__ import annotations

import threading
from dataclasses import replace

import numba
import numpy as np
import pytest

from diagnosis.simulated import inputs
from eaclutch.diagnosis import fit
from eaclutch.diagnosis.fit import plain_fit_at
from eaclutch.diagnosis.readings import PREFIX
from eaclutch.diagnosis.settings import load_thresholds
from eaclutch.diagnosis.starts import starts
from eaclutch.diagnosis.study import Study

EFFECT = ("series_compliance",)


@pytest.fixture(scope="module")
def study() -> Study:
    """The library's own laws: they hold far better than the usual tolerance."""
    return Study(inputs(EFFECT, {"series_compliance.compliance": 2e-5}), load_thresholds())


def test_where_laws_hold_better_it_goes_on_from_where_it_stands(study, monkeypatch):
    """The second round neither scouts again nor ends in a worse place than one that does."""
    sought: list[tuple[float, float]] = []
    fitted: list[tuple[float, float]] = []
    starts, finish = fit.starts, fit._finish

    def counted_starts(*given):
        sought.append(given[3])
        return starts(*given)

    def counted_fits(*given):
        fitted.append(given[5])
        return finish(*given)

    monkeypatch.setattr(fit, "starts", counted_starts)
    monkeypatch.setattr(fit, "_finish", counted_fits)
    assert study.base.mode.converged  # fitted from other starts
    sought.clear()
    fitted.clear()
    found = study.fit(EFFECT)
    smaller = found.multipliers
    assert smaller[0] < 1.0
    assert sought == [(1.0, 1.0)]
    assert fitted[-1] == smaller and fitted.count(smaller) == 1
    everywhere = fit.fit_hypothesis(
        study.forward(EFFECT), study.data, study.kernels, study.thresholds, base=study.base, size=smaller
    )
    assert sought[1:] == [smaller]
    assert found.log_evidence == pytest.approx(everywhere.log_evidence, abs=0.2)


def test_fits_from_several_starts_in_several_threads_and_ends_in_the_same_place(study, monkeypatch):
    find_mode, lock = fit.find_mode, threading.Lock()
    at_work: list[int] = []
    together: list[int] = []

    def counted(*given):
        with lock:
            at_work.append(1)
            together.append(len(at_work))
        found = find_mode(*given)
        with lock:
            at_work.pop()
        return found

    monkeypatch.setattr(fit, "find_mode", counted)
    several = []
    for threads in (3, 1):
        together.clear()
        monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", threads)
        several.append(fit.fit_hypothesis(study.forward(()), study.data, study.kernels, study.thresholds))
        assert max(together) == threads
    assert np.array_equal(several[0].mode.u, several[1].mode.u)
    assert several[0].log_evidence == several[1].log_evidence


@pytest.mark.parametrize(("tolerance", "more"), [(1.0, False), (2.0, True)])
@pytest.mark.parametrize("in_contact", [False, True])
def test_beside_a_base_fit_that_is_far_off_an_effect_also_starts_from_the_defaults(
    tolerance, more, in_contact
):
    """Where the base model's parameters are bent to explain a gap, what follows from them leads nowhere; its zeros of
    the load cell, which are looked for where runs begin in contact, may be right all the same."""
    given = inputs(EFFECT, {"series_compliance.compliance": 2e-5})
    if in_contact:
        given = replace(given, table=given.table.assign(flags="no_zero", preload_n=np.nan))
    study = Study(given, load_thresholds())
    bare, forward = study.forward(()), study.forward(EFFECT)
    u = np.full(len(bare.parameters), 0.1)
    base = plain_fit_at(bare, study.data, study.kernels, study.thresholds, u, (1.0, 1.0), True)
    base = replace(base, multipliers=(tolerance, 1.0))
    widest = max(study.thresholds["multipliers"]["tolerance"]["values"])

    def begun(seeds=None):
        return starts(forward, study.data, study.kernels, (1.0, 1.0), base, None, seeds, widest)

    default = forward.priors.to_normal(np.array([p.default for p in forward.parameters]))
    zeros = np.array([name.startswith(PREFIX) for name in forward.priors.names])
    assert any(zeros) == in_contact
    expected = [default, np.where(zeros, 0.1, default)][: 1 + in_contact] if more else []
    found = begun()
    assert len(found) == 2 + len(expected)
    assert all(np.array_equal(u, v) for u, v in zip(found[2:], expected, strict=True))
    assert len(begun({"damping": 1.2})) == 2  # where another fit's parameters are known


def test_a_fit_of_effects_goes_on_from_what_lies_near_its_end(study, monkeypatch):
    """From its one start it leads nowhere; the first look around finds the place, the second nothing more."""
    there = study.fit(EFFECT)
    looked, seek = [], fit.find_mode

    def stuck(forward, values, covariance_at, u):
        if np.allclose(u, there.mode.u):
            return seek(forward, values, covariance_at, u)
        predicted = forward.predict(forward.priors.from_normal(u))[0]
        return fit.mode_at(forward, u, predicted, None, True)

    def near(forward, data, found):
        looked.append(found.peak)
        return [there.mode.u] if len(looked) == 1 else []

    monkeypatch.setattr(fit, "starts", lambda *given: [there.mode.u + 0.5])
    monkeypatch.setattr(fit, "find_mode", stuck)
    monkeypatch.setattr(fit, "nearby", near)
    found = fit.fit_hypothesis(
        study.forward(EFFECT),
        study.data,
        study.kernels,
        study.thresholds,
        base=study.base,
        size=there.multipliers,
    )
    assert len(looked) >= 2 and looked[1] > looked[0] + 1.0
    # the covariance holds the effect's signature where a fit starts
    assert found.log_evidence == pytest.approx(there.log_evidence, abs=1.0)

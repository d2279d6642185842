"""The paper's point fits: exact on made data, and the published numbers on the published recordings."""

from __future__ import annotations

import numpy as np
import pytest

from eaclutch.inference.choices import AUTHORS_WEIGHTS, contact_rows, table
from eaclutch.inference.published_fits import contact_fit, dielectric_fit, multiplier_fit
from eaclutch.physics.laws import capacitance_scale, contact_force, permittivity
from eaclutch.records import Bench, CapacitanceReadings, Spectrum
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.capacitance import read_capacitance
from eaclutch.rig.spectra import read_spectra


def test_contact_fit_is_exact_without_noise():
    bench = Bench("x")
    gap = np.linspace(3e-6, 1.2e-5, 200)
    width = np.repeat([2e-3, 3e-3], 200)
    gaps = np.tile(gap, 2)
    force = contact_force(gaps, 5e14, 2.8e-6, bench.fixture.overlap_length, width)
    capacitance = capacitance_scale(bench.pad, width, bench.fixture.overlap_length) / (gaps + 24e-6 / 53.2)
    readings = CapacitanceReadings(force, capacitance, width, ("t",) * 400, ("s",) * 400)
    k, sigma = contact_fit(readings, bench, film=24e-6, kappa=53.2, force_max=4.0)
    assert k == pytest.approx(5e14, rel=0.02) and sigma == pytest.approx(2.8e-6, rel=0.005)
    rows = table(contact_rows(readings, bench, None, np.random.default_rng(0)))
    assert list(rows["quantity"][:2]) == ["contact_stiffness", "roughness_sd"] and len(rows) == 8


def test_dielectric_fit_follows_the_weights():
    frequency = np.geomspace(1e2, 1e7, 30)
    one = Spectrum("a", frequency, permittivity(frequency, 50.0, 4.0, 2e-6, 0.6))
    two = Spectrum("b", frequency, permittivity(frequency, 56.0, 4.0, 3e-6, 0.55))
    np.testing.assert_allclose(dielectric_fit([one], {}), (50.0, 2e-6, 0.6), rtol=1e-4)
    assert dielectric_fit([one, two], {"b": 1000.0})[0] == pytest.approx(56.0, abs=0.1)


def test_multiplier_fit_of_a_known_line():
    voltage = np.repeat([150.0, 200.0, 250.0, 300.0], 5)
    grid = np.exp(np.linspace(np.log(0.05), np.log(20), 80))
    base = (voltage / 200) ** 2
    log_capacity = np.log(grid[:, None] * base[None, :])
    measured = (2.4 - 0.0058 * voltage) * base
    slope, intercept, mean = multiplier_fit(log_capacity, measured, voltage, grid)
    assert (slope, intercept) == (pytest.approx(-0.0058, abs=1e-5), pytest.approx(2.4, abs=2e-3))
    assert mean == pytest.approx(2.4 - 0.0058 * 225, abs=2e-3)
    log_capacity[grid > 0.8] = np.nan  # the model pulls in: no crossing for the lower voltages
    assert np.isnan(multiplier_fit(log_capacity, measured * 10, voltage, grid)[0])


@pytest.mark.published
def test_published_numbers_by_the_authors_choices(published):
    campaign = open_campaign(published)
    readings = read_capacitance(campaign)
    keep = np.flatnonzero(readings.width < 6e-3)
    readings = CapacitanceReadings(
        readings.force[keep], readings.capacitance[keep], readings.width[keep],
        tuple(readings.trial[i] for i in keep), tuple(readings.source[i] for i in keep),
    )  # fmt: skip
    for film, kappa, force_max, k, sigma in (
        (28e-6, 45.0, 4.0, 5.4e14, 2.80e-6), (28e-6, 45.0, 8.0, 2.09e15, 2.37e-6), (24e-6, 53.2, 4.0, 5.98e14, 2.83e-6),
    ):  # fmt: skip
        found = contact_fit(readings, campaign.bench, film=film, kappa=kappa, force_max=force_max)
        assert found == (pytest.approx(k, rel=0.01), pytest.approx(sigma, rel=0.003))
    spectra = read_spectra(campaign)
    weighted = dielectric_fit(spectra, AUTHORS_WEIGHTS)
    assert weighted == (
        pytest.approx(54.2, abs=0.05),
        pytest.approx(2.82e-6, abs=1e-8),
        pytest.approx(0.562, abs=1e-3),
    )
    plain = dielectric_fit(spectra, {})
    assert plain == (
        pytest.approx(52.8, abs=0.05),
        pytest.approx(3.04e-6, abs=1e-8),
        pytest.approx(0.588, abs=1e-3),
    )

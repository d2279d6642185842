"""Trials at levels of force: what they share is told from what each level does by itself."""

import numpy as np
import pytest

from eaclutch.diagnosis.capacitance_levels import FORCE_LEVELS, LARGEST_FORCE, USUAL_SD, levels
from eaclutch.records import CapacitanceReadings

FORCE = np.repeat(FORCE_LEVELS[FORCE_LEVELS < LARGEST_FORCE], 6) * np.tile(np.linspace(0.9, 1.1, 6), 10)


def curve(force):
    """log C of a film that is pressed flat."""
    return np.log(2e-11) + 0.12 * np.log(force)


def trials(offsets, noise, rng, *, lowest=()):
    """Readings of one width; ``lowest`` [N]: where each trial begins."""
    force, values, names = [], [], []
    for number, offset in enumerate(offsets):
        here = FORCE[lowest[number] <= FORCE] if lowest else FORCE
        force.append(here)
        values.append(np.exp(curve(here) + offset + noise * rng.standard_normal(len(here))))
        names += [str(number)] * len(here)
    force, values = np.concatenate(force), np.concatenate(values)
    return CapacitanceReadings(force, values, np.full(len(force), 2e-3), tuple(names), ("log",) * len(force))


def test_an_offset_is_told_from_scatter_at_the_levels():
    rng = np.random.default_rng(0)
    offsets = 0.03 * rng.standard_normal(40)
    found = levels(trials(offsets, 0.01, rng))
    assert len(found) == 10
    assert found[0].offset_sd == pytest.approx(np.std(offsets, ddof=1) / np.sqrt(40), rel=0.03)
    own = 0.01 / np.sqrt(6)  # six readings a level, neighbours share some
    assert all(
        0.5 * own < level.sd * np.sqrt(40) < 1.5 * np.hypot(own, 1e-3 * np.sqrt(40)) for level in found
    )


def test_scatter_at_the_levels_alone_is_no_offset():
    sizes = [
        levels(trials(np.zeros(3), 0.02, np.random.default_rng(seed)))[0].offset_sd for seed in range(20)
    ]
    assert np.median(sizes) < 0.003


def test_a_trial_that_begins_later_does_not_bend_the_curve():
    rng = np.random.default_rng(1)
    found = levels(trials([0.05, 0.0], 1e-4, rng, lowest=[0.0, 0.4]))
    shape = np.array([level.log_capacitance - curve(level.force) for level in found])
    assert np.ptp(shape) < 1e-3
    assert found[0].offset_sd == pytest.approx(0.025, rel=0.05)


def test_one_trial_has_the_usual_uncertainty():
    (first, *_) = levels(trials([0.0], 0.01, np.random.default_rng(2)))
    assert first.offset_sd == pytest.approx(USUAL_SD) and first.sd == pytest.approx(USUAL_SD, rel=0.01)


def test_readings_between_levels_are_carried_to_them():
    """Few readings, all above their levels: taken as they are the curve would be off by its slope, 2 %."""
    rng = np.random.default_rng(3)
    force = FORCE_LEVELS[:8] * 1.18
    values = np.exp(curve(force) + 1e-5 * rng.standard_normal(8))
    readings = CapacitanceReadings(force, values, np.full(8, 2e-3), ("1",) * 8, ("log",) * 8)
    found = levels(readings)
    assert [level.log_capacitance - float(curve(level.force)) for level in found] == pytest.approx(
        [0.0] * 8, abs=3e-5
    )
    assert levels(readings)[0].force == FORCE_LEVELS[0]
    lonely = CapacitanceReadings(force[:1], values[:1], np.full(1, 2e-3), ("1",), ("log",))
    assert len(levels(lonely)) == 1

"""Friction that outlives the pull."""

from __future__ import annotations

import numpy as np
import pytest

from eaclutch.physics.effects import BASE
from eaclutch.physics.model import ClutchModel

TIMES = ("release_time_10_s", "release_time_50_s", "release_time_90_s")


@pytest.mark.parametrize(("lag", "share", "power"), [(2e-4, 1.0, 0.0), (4e-4, 0.5, 0.5), (1e-6, 0.7, 0.0)])
def test_a_sluggish_contact_holds_what_a_low_pass_of_its_load_says(runs, bench, lag, share, power):
    """Without a mass on the load cell the reading is the friction: part of it runs after that of a prompt contact."""
    effects = tuple(name for name in BASE if name != "load_cell_dynamics")
    alike = {"base_static": 0.173, "base_kinetic": 0.173, "film_static": 0.154, "film_kinetic": 0.154}
    prompt, sluggish = ClutchModel(bench, effects), ClutchModel(bench, (*effects, "sluggish_contact"))
    still = runs(friction_before=0.15)
    level = prompt.predict(still, alike).values["shear_capacity_n"][0, 0] + 0.15
    conditions = runs(friction_before=0.15, switch_off_force=level)
    time = np.linspace(1e-9, 4e-3, 8001)
    force = prompt.history(conditions, 0, alike, 3.0 + time)
    # what the film carries at switch-off: all but the base's share, which the preload gives
    row = prompt.rows(conditions, alike)[0][0, 0]
    preload = (
        0.15 - 0.173 * (row["substrate_weight"] + row["film_weight"]) - 0.154 * row["film_weight"]
    ) / 0.327
    base = 0.173 * (row["substrate_weight"] + row["film_weight"] + preload)
    tau = lag * ((level - base) / 0.154) ** power
    late = np.empty_like(force)
    late[0] = level  # a friction that has not begun to fall, below what the force has climbed to since
    for i in range(1, len(time)):
        step = (time[i] - time[i - 1]) / tau
        kept = np.exp(-step)
        rise = (force[i] - force[i - 1]) / step
        late[i] = force[i] - rise + (late[i - 1] - force[i - 1] + rise) * kept
    own = {
        "sluggish_contact.lag": lag,
        "sluggish_contact.share": share,
        "sluggish_contact.load_exponent": power,
    }
    found = sluggish.history(conditions, 0, alike | own, 3.0 + time)
    seen = time > 1e-5  # before, the film's inertia takes part, which no contact lags behind
    np.testing.assert_allclose(
        found[seen], ((1.0 - share) * force + share * late)[seen], atol=2e-3 * level, rtol=0.0
    )


def test_a_sluggish_contact_delays_release_and_nothing_else(runs, bench):
    model = ClutchModel(bench, (*BASE, "sluggish_contact"))
    conditions = runs(frequency=[1.0, 1000.0], switch_off_force=[0.6, 0.5])
    found = [
        model.predict(conditions, {"sluggish_contact.lag": lag}).values for lag in (0.0, 1e-9, 2e-4, 4e-4)
    ]
    times = np.array([[each[name][0] for name in TIMES] for each in found])
    np.testing.assert_allclose(times[1], times[0], rtol=1e-3)
    assert np.all(np.diff(times[[0, 2, 3]], axis=0) > 0.0)
    for name in ("shear_capacity_n", "ramp_rate_n_s", "slip_fraction"):
        np.testing.assert_allclose(found[3][name], found[0][name], rtol=1e-6)

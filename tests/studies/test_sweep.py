"""Design maps against single predictions, and their inverse."""

from dataclasses import replace

import numpy as np
import pytest

from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, InputError, Substrate
from eaclutch.studies.sweep import Design, DesignMap, design_conditions, design_map

BENCH = Bench("sweep", substrates={"brass": Substrate(thickness={2e-3: 2e-3, 5e-3: 2.5e-3})})
DRAWS = {"roughness_sd": np.array([2.7e-6, 2.8e-6, 2.9e-6])}


def test_a_map_holds_what_single_predictions_say():
    x, y = ("voltage_v", [200.0, 300.0]), ("film_thickness_um", [20.0, 30.0])
    drawn = design_map(BENCH, ClutchModel, DRAWS, Design("brass"), x, y)
    thick = replace(BENCH, pad=replace(BENCH.pad, film_thickness=30e-6))
    conditions = design_conditions(thick, Design("brass"), {"voltage_v": np.array([200.0])})
    single = ClutchModel(thick).predict(conditions, DRAWS, ["shear_capacity_n"])
    np.testing.assert_allclose(
        drawn.values["shear_capacity_n"][:, 1, 0], single.values["shear_capacity_n"][:, 0], rtol=1e-9
    )


def test_capacity_grows_with_voltage_and_engagement_slows_with_width():
    drawn = design_map(
        BENCH,
        ClutchModel,
        DRAWS,
        Design("brass"),
        ("voltage_v", [150.0, 225.0, 300.0]),
        ("width_mm", [2.0, 4.0]),
    )
    assert (np.diff(drawn.values["shear_capacity_n"], axis=2) > 0).all()
    assert (np.diff(drawn.values["engagement_time_s"], axis=1) > 0).all()


def test_probability_counts_draws_and_a_missing_value_is_a_miss():
    values = {"release_time_90_s": np.array([[[1e-3]], [[np.nan]], [[3e-3]], [[1.5e-3]]])}
    drawn = DesignMap("voltage_v", "width_mm", np.array([300.0]), np.array([2.0]), values)
    assert drawn.probability({"release_time_90_s": (0.0, 2e-3)})[0, 0] == 0.5


def test_an_unknown_axis_is_refused():
    with pytest.raises(InputError, match="is not an axis"):
        design_map(BENCH, ClutchModel, DRAWS, Design("brass"), ("colour", [1.0]), ("width_mm", [2.0]))

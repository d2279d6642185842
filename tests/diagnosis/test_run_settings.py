"""What was set in each run, as far as the runs table tells."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from eaclutch.diagnosis.run_settings import estimated_preload
from eaclutch.records import Friction, Gaussian


def test_a_preload_that_the_table_lacks_is_worked_out_from_this_bench_s_friction():
    conditions = SimpleNamespace(friction_before=np.array([0.3, 0.3, np.nan]))
    slippery = Friction(base_kinetic=Gaussian(0.1, 0.01), film_kinetic=Gaussian(0.05, 0.01))
    table = pd.DataFrame({"preload_n": ["0.7", "", ""]})
    assert estimated_preload(table, conditions, slippery) == pytest.approx([0.7, 2.0, 0.0])
    assert estimated_preload(table.drop(columns="preload_n"), conditions, slippery)[0] == pytest.approx(2.0)

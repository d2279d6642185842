"""Files: all groups, users' own ArviZ code, equal bytes on repetition, priors where there is no data, the summary."""

from __future__ import annotations

import hashlib
import warnings

import numpy as np
import pytest

from eaclutch.config.document import load_schema
from eaclutch.files import plain
from eaclutch.inference import storage
from eaclutch.inference.draws import inside, load_draws, with_prior_draws
from eaclutch.inference.hyperparameters import HYPERPARAMETERS
from eaclutch.inference.posterior import gate, run_stage
from eaclutch.inference.sampling import SamplerSettings
from eaclutch.inference.stages.load_cell import load_cell_problem
from eaclutch.inference.summary import summarise
from eaclutch.physics.model import ClutchModel
from eaclutch.physics.parameters import base_parameters
from eaclutch.records import Bench, BurstFeatures, InputError

with warnings.catch_warnings():
    warnings.simplefilter("ignore", FutureWarning)
    import arviz

PARAMETERS = dict(HYPERPARAMETERS) | base_parameters(Bench("x"), "linear")
SETTINGS = SamplerSettings(
    ensembles=2, walkers=20, check_every=200, max_steps=1200, stored_draws=100, warm_up=150
)
GROUPS = {"posterior", "prior", "posterior_predictive", "log_likelihood", "observed_data", "sample_stats"}


@pytest.fixture(scope="module")
def problem():
    rng = np.random.default_rng(0)
    return load_cell_problem(
        BurstFeatures(
            640 + rng.standard_normal(8), np.ones(8), 0.05 + 0.002 * rng.standard_normal(8), np.full(8, 2e-3)
        ),
        PARAMETERS,
    )


@pytest.fixture(scope="module")
def files(problem, tmp_path_factory):
    """A stage with data and one without, as written."""
    folder = tmp_path_factory.mktemp("posterior")
    data, sampled = run_stage(problem, SETTINGS, 4)
    storage.save(folder / "load_cell.nc", data)
    bare = load_cell_problem(None, PARAMETERS)
    empty, none = run_stage(bare, SETTINGS, 4)
    storage.save(folder / "prior.nc", empty)
    assert none is None
    return folder, sampled


def test_all_groups_and_variables_with_units(files, problem):
    folder, sampled = files
    found = arviz.from_netcdf(folder / "load_cell.nc")
    assert set(found.groups()) >= GROUPS
    assert dict(found.posterior.sizes)["chain"] == SETTINGS.ensembles
    assert {"stiffness", "mass", "damping"} <= set(found.posterior.data_vars)
    assert found.posterior["mass"].attrs["unit"] == "kg"
    assert found.observed_data["swing"].size == 16
    assert sampled.converged and found.attrs["converged"] == "true"


def test_users_own_arviz_code_works(files):
    found = arviz.from_netcdf(files[0] / "load_cell.nc")
    table = arviz.summary(found, var_names=["mass"])
    assert table.loc["mass", "mean"] == pytest.approx(0.0011, rel=0.1)
    assert np.isfinite(arviz.loo(found).elpd_loo)


def test_prior_only_stage(files):
    found = storage.load(files[0] / "prior.nc")
    assert found.source == "prior" and found.converged is None
    assert found.draws["stiffness"].std() == pytest.approx(500, rel=0.1)
    groups = set(arviz.from_netcdf(files[0] / "prior.nc").groups())
    assert {"posterior", "prior"} <= groups and "observed_data" not in groups


def _content(path):
    """Digest of the file's numbers and attributes but for times."""
    data = storage.read(path)
    digest = hashlib.sha256()
    for group in sorted(data.groups()):
        part = data[group]
        attributes = {k: str(v) for k, v in sorted(part.attrs.items()) if k not in ("created_at",)}
        digest.update(repr((group, attributes)).encode())
        for name in sorted(part.data_vars):
            digest.update(np.ascontiguousarray(part[name].values.astype(str)).tobytes())
    return digest.hexdigest()


def test_same_seed_same_file(files, problem, tmp_path):
    again, _ = run_stage(problem, SETTINGS, 4)
    storage.save(tmp_path / "again.nc", again)
    assert _content(tmp_path / "again.nc") == _content(files[0] / "load_cell.nc")
    other, _ = run_stage(problem, SETTINGS, 5)
    storage.save(tmp_path / "other.nc", other)
    assert _content(tmp_path / "other.nc") != _content(files[0] / "load_cell.nc")


def test_summary_fits_its_schema_and_the_draws(files, problem):
    jsonschema = pytest.importorskip("jsonschema")
    folder, sampled = files
    summary = summarise([folder / "load_cell.nc"])
    document = plain(summary)
    jsonschema.validate(document, load_schema("summary"))
    row = document["load_cell"]["parameters"]["mass"]
    assert row["r_hat"] <= 1.01 and row["ess_bulk"] >= 400 and row["unit"] == "kg"
    assert row["mean"] == pytest.approx(sampled.flat[:, 1].mean(), rel=0.01)
    assert row["prior_sd"] == pytest.approx(5e-5, rel=0.01)
    bare = plain(summarise([folder / "prior.nc"]))
    jsonschema.validate(bare, load_schema("summary"))
    assert bare["load_cell"]["converged"] is None and bare["load_cell"]["source"] == "prior"
    assert bare["load_cell"]["parameters"]["mass"]["r_hat"] is None


def test_gate_says_what_failed(problem):
    jsonschema = pytest.importorskip("jsonschema")
    data, sampled = run_stage(problem, SamplerSettings(walkers=20, check_every=10, max_steps=10), 4)
    document = plain(gate(problem, SETTINGS, sampled, data))
    jsonschema.validate(document, load_schema("gate"))
    assert document["converged"] is False and document["failures"]
    assert data.attrs["converged"] == "false"
    jsonschema.validate(plain(gate(problem, SETTINGS, None, data)), load_schema("gate"))


def test_joint_draws_keep_rows_together_and_fill_from_priors(files):
    joint = load_draws([files[0] / "load_cell.nc"], 150)
    assert set(joint) == {"stiffness", "mass", "damping"}
    assert np.corrcoef(joint["stiffness"], joint["mass"])[0, 1] > 0.9  # a row is one draw
    full = with_prior_draws(joint, base_parameters(Bench("x"), "linear"), 150, np.random.default_rng(0))
    assert full["film_static"].shape == (150,) and "slip_phase" not in full
    # what a base effect leaves open is drawn, its strength is not
    known = ClutchModel(Bench("x")).parameters
    full = with_prior_draws(joint, known, 150, np.random.default_rng(0))
    assert full["drive_rise_fall.reversal_share"].std() > 0.2
    assert not any(name.endswith(".strength") for name in full)


def test_draws_that_left_their_bounds_are_put_back():
    share = "drive_rise_fall.reversal_share"
    known = ClutchModel(Bench("x")).parameters
    found = inside({share: np.array([-0.2, 0.4, 1.7]), "other": np.array([9.0])}, known)
    assert found[share].tolist() == [0.0, 0.4, 1.0] and found["other"].tolist() == [9.0]


def test_a_second_file_of_a_stage_is_an_error(files):
    with pytest.raises(InputError, match="second file"):
        load_draws([files[0] / "load_cell.nc", files[0] / "prior.nc"], 10)


def test_a_file_that_is_none_is_an_error(tmp_path):
    (tmp_path / "x.nc").write_bytes(b"no netcdf")
    with pytest.raises(InputError, match="not a posterior file"):
        storage.load(tmp_path / "x.nc")

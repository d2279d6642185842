"""A short run of the fuzzer (benchmarks/torture/fuzz.py), with numbers that once failed among its trials."""

import importlib.util
import sys
from pathlib import Path

import pytest

_SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "torture" / "fuzz.py"
_SPEC = importlib.util.spec_from_file_location("fuzz", _SCRIPT)
fuzz = importlib.util.module_from_spec(_SPEC)
sys.modules["fuzz"] = fuzz  # a dataclass looks its module up
_SPEC.loader.exec_module(fuzz)
READERS = fuzz.readers()
ONCE_FAILED = {"log_npy": (12, 17, 657), "load_cell": (60, 271, 1003)}


@pytest.mark.parametrize("name", READERS)
def test_mutated_input_is_read_or_refused(name, tmp_path):
    for number in (*range(10), *ONCE_FAILED.get(name, ())):
        folder = tmp_path / str(number)
        assert fuzz.trial(name, READERS[name], number, folder) in ("read", "refused")


@pytest.mark.parametrize("name", set(READERS) - {"reply", "name", "record"})
def test_what_is_not_mutated_is_read(name, tmp_path, monkeypatch):
    monkeypatch.setattr(fuzz, "mutate", lambda content, rng: content)
    assert fuzz.trial(name, READERS[name], 0, tmp_path) == "read"

"""A short run of the fuzzer (benchmarks/torture/fuzz.py), with numbers that once failed among its trials."""

import fuzz
import pytest

READERS = fuzz.readers()
ONCE_FAILED = {"log_npy": (12, 17, 657), "load_cell": (60, 271, 1003)}


@pytest.mark.parametrize("name", READERS)
def test_mutated_input_is_read_or_refused(name, tmp_path):
    for number in (*range(10), *ONCE_FAILED.get(name, ())):
        folder = tmp_path / str(number)
        assert fuzz.trial(name, READERS[name], number, folder) in ("read", "refused")


@pytest.mark.parametrize("name", sorted(set(READERS) - {"reply", "name", "record"}))
def test_what_is_not_mutated_is_read(name, tmp_path, monkeypatch):
    monkeypatch.setattr(fuzz, "mutate", lambda content, rng: content)
    assert fuzz.trial(name, READERS[name], 0, tmp_path) == "read"

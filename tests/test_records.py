"""What all rooms exchange."""

from __future__ import annotations

import pickle

from eaclutch.records import InputError


def test_an_input_error_comes_whole_from_another_process() -> None:
    sent = InputError("runs.csv, row 3", "holds no number", "mend it")
    back = pickle.loads(pickle.dumps(sent))
    assert (str(back), back.where, back.what, back.remedy) == (str(sent), sent.where, sent.what, sent.remedy)

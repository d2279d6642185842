"""Parts of the config and the bench that a job depends on, as text that changes only when they do."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from typing import Any

from eaclutch.files import plain
from eaclutch.records import Bench, InputError


def bench_slice(bench: Bench, parts: Iterable[str]) -> str:
    """The named fields of the bench as JSON with sorted keys; all of them where none is named."""
    facts = plain({**vars(bench), "sessions": _spans(bench)})
    chosen = {name: facts[name] for name in (list(parts) or facts)}
    return json.dumps(chosen, sort_keys=True)


class Slice(dict[str, Any]):
    """A part of the config as a rule passes it; a key that it lacks is an error for the reader's eyes."""

    def __missing__(self, key: str) -> Any:
        raise InputError(
            "--settings", f"lacks {key!r}", "pass the config's part as JSON, as the workflow does"
        )


def parse_settings(text: str) -> Slice:
    """The JSON of ``--settings``. Raises InputError where it is no JSON object."""
    try:
        content = json.loads(text, object_hook=Slice)
    except json.JSONDecodeError as error:
        raise InputError("--settings", f"is not JSON ({error})", "pass the config's part as JSON") from error
    if not isinstance(content, Slice):
        raise InputError("--settings", "is no JSON object", "pass the config's part as JSON")
    return content


def _spans(bench: Bench) -> Any:
    if bench.sessions is None:
        return "by_date"
    return [[span.name, span.start.isoformat(), span.end.isoformat()] for span in bench.sessions]


def job_seed(root: int, labels: Iterable[object]) -> int:
    """A seed below 2**32 from the config's seed and a job's labels; equal labels give equal seeds."""
    text = "\0".join(map(str, (root, *labels)))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")

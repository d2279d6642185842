"""config/README.md from the schema, so that every key is described once."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from eaclutch.config.document import load_schema

_HEAD = """# Config

Written from `workflow/schemas/config.schema.yaml` by `eaclutch config-readme`; a test fails when the two differ.

* `config.yaml`: the default, a small campaign that this project's own simulator made (`data/README.md`).
* `published.yaml`: the recordings of Rauf & Follmer (2025), in a folder that you name.
* `rig.yaml`: a live rig on a serial port.
* `quick.yaml`: short sampling and few candidates, on top of another config, for a first look.

`snakemake --cores all --configfile config/published.yaml mine.yaml --config campaign=<folder>`: later files win,
`--config` wins over all. A relative path belongs to the file that states it; on the command line, to the working
directory. Configs are trusted like code: Snakemake runs Python in a file that asks for it. Campaign folders are not
trusted. Wrong keys and values stop with one line `eaclutch: error: ...`; a config file that is not there, or is no
YAML, stops before that, in Snakemake's own words, which name it.

| key | default | values | meaning |
|---|---|---|---|
"""


def config_readme() -> str:
    """The text of config/README.md: a row for every key of the config."""
    rows = [
        f"| `{key}` | {_default(part)} | {_values(part)} | {part['description']} |"
        for key, part in _keys(load_schema("config"))
    ]
    return _HEAD + "\n".join(rows) + "\n"


def _keys(schema: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Mapping[str, Any]]]:
    for name, part in schema.get("properties", {}).items():
        if "properties" in part:
            yield from _keys(part, f"{prefix}{name}.")
        else:
            yield prefix + name, part


def _default(part: Mapping[str, Any]) -> str:
    return f"`{json.dumps(part['default'])}`" if "default" in part else ""


def _values(part: Mapping[str, Any]) -> str:
    if "enum" in part:
        return ", ".join(f"`{value}`" for value in part["enum"])
    kinds = part.get("type", "any")
    text = kinds if isinstance(kinds, str) else " or ".join(kinds)
    limits = [
        f"{sign} {part[key]}"
        for key, sign in (
            ("exclusiveMinimum", ">"),
            ("minimum", ">="),
            ("exclusiveMaximum", "<"),
            ("maximum", "<="),
        )
        if key in part
    ]
    return ", ".join([text, *limits])

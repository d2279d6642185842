"""The config: files and overrides merged key by key, checked against the closed schema, completed."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from eaclutch.config.document import check, load_schema, read_scalars, read_yaml, text_keys, with_defaults
from eaclutch.records import InputError

_PACKAGE = Path(__file__).resolve().parents[1]
_ROOT = _PACKAGE.parents[1]


def effect_names() -> tuple[str, ...]:
    """Names of all effects in the library: the folder's listing (importing them would load the solver)."""
    folder = _PACKAGE / "physics" / "effects"
    return tuple(sorted(path.stem for path in folder.glob("*.py") if not path.stem.startswith("_")))


def load_config(
    paths: Sequence[str | Path] = (), overrides: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """The config of ``paths`` (later ones win) and ``overrides`` (win over all), complete and checked.

    Relative paths are resolved against the folder of the file that states them, those in ``overrides``
    against the working directory. Returns plain data; every key of the schema is present.
    Raises InputError that names the file and the key.
    """
    schema = load_schema("config")
    merged: dict[str, Any] = {}
    for path in map(Path, paths):
        document = read_yaml(path)
        _check(document, path)
        merged = _merge(merged, _resolved(document, schema, path.resolve().parent))
    if overrides:
        document = {
            str(key): text_keys(read_scalars(value)) if isinstance(value, Mapping) else value
            for key, value in overrides.items()
        }
        _check(document, "--config")
        merged = _merge(merged, _resolved(document, schema, Path.cwd()))
    config = with_defaults(merged, schema)
    if "campaign" not in merged:
        config["campaign"] = str(_ROOT / config["campaign"])
    _check_model(config, ", ".join(map(str, paths)) or "config")
    return config


def _check(document: Mapping[str, Any], where: object) -> None:
    check(document, "config", where)
    known = effect_names()
    for section, key in (
        ("model", "effects"),
        ("model", "without"),
        ("diagnosis", "candidates"),
        ("capture", "effects"),
    ):
        for name in document.get(section, {}).get(key) or ():
            if name not in known:
                raise InputError(
                    f"{where}, {section}.{key}",
                    f"there is no effect {name!r}",
                    f"give one of {', '.join(known)}",
                )


def _check_model(config: Mapping[str, Any], where: str) -> None:
    model = config["model"]
    switched_on = model["effects"]
    if switched_on is not None:
        for name in model["without"]:
            if name in switched_on:
                raise InputError(
                    f"{where}, model.without",
                    f"{name} is also in model.effects",
                    "take it out of one of the two",
                )
    edges = config["observables"]["preload_bin_edges_n"]
    if any(b <= a for a, b in itertools.pairwise(edges)):
        raise InputError(f"{where}, observables.preload_bin_edges_n", "does not increase", "sort the edges")


def _merge(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(first)
    for key, value in second.items():
        both = isinstance(merged.get(key), Mapping) and isinstance(value, Mapping)
        merged[key] = _merge(merged[key], value) if both else value
    return merged


def _resolved(document: Any, schema: Mapping[str, Any], folder: Path) -> Any:
    """``document`` with every value whose schema says ``format: path`` made absolute."""
    if schema.get("format") == "path" and isinstance(document, str):
        return str(folder / Path(document).expanduser())
    if isinstance(document, Mapping):
        parts = schema.get("properties", {})
        return {key: _resolved(value, parts.get(key, {}), folder) for key, value in document.items()}
    return document

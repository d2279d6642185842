"""Reading a YAML file that somebody else wrote: bounded, plain, and checked against a closed schema."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError, best_match

from eaclutch.records import InputError

SCHEMAS = Path(__file__).resolve().parents[1] / "schemas"
MAX_BYTES = 1_000_000
MAX_DEPTH = 20


class _Loader(yaml.SafeLoader):
    """Safe YAML without aliases (a few lines of them fill the memory) and without duplicate keys.

    Dates stay text, and ``1e-3`` is a number as it is in every other language.
    """

    depth = 0

    def compose_node(self, parent, index):
        mark = self.peek_event().start_mark
        if self.check_event(yaml.AliasEvent):
            raise yaml.constructor.ConstructorError(None, None, "an alias is not allowed", mark)
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise yaml.constructor.ConstructorError(None, None, "nested too deeply", mark)
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def construct_mapping(self, node, deep=False):
        keys = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, (str, int, float)):
                raise yaml.constructor.ConstructorError(None, None, "a key is no name", key_node.start_mark)
            if str(key) in keys:
                problem = f"the key {str(key)!r} stands twice"
                raise yaml.constructor.ConstructorError(None, None, problem, key_node.start_mark)
            keys.add(str(key))
        return super().construct_mapping(node, deep)


# YAML 1.1 reads 20241103_16_20_52 as a number, 1:30 as 90, 010 as 8, no as false and a date as an object.
_Loader.yaml_implicit_resolvers = {}
for _tag, _pattern, _first in (
    ("null", r"^(~|null|Null|NULL|)$", ["~", "n", "N", ""]),
    ("bool", r"^(true|True|TRUE|false|False|FALSE)$", list("tTfF")),
    ("int", r"^[-+]?[0-9]+$", list("-+0123456789")),
    (
        "float",
        r"^([-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$",
        list("-+.0123456789"),
    ),
):
    _Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(_pattern), _first)


@functools.cache
def load_schema(name: str) -> dict[str, Any]:
    """The schema ``<name>.schema.yaml`` that comes with the package."""
    return yaml.safe_load((SCHEMAS / f"{name}.schema.yaml").read_text(encoding="utf-8"))


def read_yaml(path: Path) -> dict[str, Any]:
    """The mapping in a YAML file, keys as text. Raises InputError with file and row."""
    try:
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise InputError(path, "is no file", "put the settings file itself there")
        if path.stat().st_size > MAX_BYTES:
            raise InputError(path, f"larger than {MAX_BYTES} bytes", "give a settings file, not data")
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(path, "there is no such file", "check the path") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"cannot be read ({error})", "make it a readable UTF-8 text file") from None
    try:
        document = yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        row = f"{path}, row {error.problem_mark.line + 1}" if error.problem_mark else path
        raise InputError(row, error.problem or "is not YAML", "mend the YAML") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise InputError(path, f"is not YAML ({error})", "mend the YAML") from None
    if document is None:
        document = {}
    if not isinstance(document, Mapping):
        raise InputError(path, "is not a mapping of keys", "write key: value lines")
    return text_keys(document)


def text_keys(value: Any) -> Any:
    """``value`` with every mapping's keys as text (YAML reads ``2: 2`` with a number as the key)."""
    if isinstance(value, Mapping):
        return {str(key): text_keys(item) for key, item in value.items()}
    if isinstance(value, list):
        return [text_keys(item) for item in value]
    return value


def read_scalars(value: Any) -> Any:
    """``value`` with the texts inside its mappings and lists read as YAML scalars (``{a: "1"}`` to ``{a: 1}``).

    Snakemake hands on what stands within the braces of ``--config key={...}`` as text.
    """
    if isinstance(value, Mapping):
        return {key: read_scalars(item) for key, item in value.items()}
    if isinstance(value, list):
        return [read_scalars(item) for item in value]
    return yaml.load(value, Loader=_Loader) if isinstance(value, str) else value


def check(document: Any, schema: str, where: object) -> None:
    """Raise an InputError for the worst departure of ``document`` from the schema, naming the key."""
    for key, number in _numbers(document):
        if not math.isfinite(number):
            raise InputError(f"{where}, {key}", "is not a finite number", "give a finite number")
    validator = Draft202012Validator(load_schema(schema))
    error = best_match(validator.iter_errors(document))
    if error is not None:
        raise InputError(f"{where}, {_key(error)}", *_words(error))


def with_defaults(document: Any, schema: Mapping[str, Any]) -> Any:
    """``document`` completed by the schema's defaults, key by key; objects without a default are filled too."""
    if schema.get("type") != "object" or not isinstance(document, Mapping):
        return document
    filled = {}
    properties = schema.get("properties", {})
    for key, part in properties.items():
        if key in document:
            filled[key] = with_defaults(document[key], part)
        elif "default" in part:
            filled[key] = with_defaults(text_keys(part["default"]), part)
        elif part.get("type") == "object" and "properties" in part:
            filled[key] = with_defaults({}, part)
    further = schema.get("additionalProperties")
    for key, value in document.items():
        if key not in properties:
            filled[key] = with_defaults(value, further) if isinstance(further, Mapping) else value
    return filled


def _numbers(value: Any, key: str = "") -> Iterator[tuple[str, float]]:
    if isinstance(value, Mapping):
        for name, item in value.items():
            yield from _numbers(item, f"{key}.{name}" if key else str(name))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _numbers(item, f"{key}[{index}]")
    elif isinstance(value, float):
        yield key, value


def _key(error: ValidationError) -> str:
    path = list(error.absolute_path)
    if error.validator == "additionalProperties" and isinstance(error.instance, Mapping):
        schema: Any = error.schema
        known = set(schema.get("properties", {}))
        path.append(sorted(set(error.instance) - known)[0])
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.lstrip(".") or "top level"


def _words(error: ValidationError) -> tuple[str, str]:
    """What is wrong and the remedy, in the words of somebody who wrote the file."""
    limit: Any = error.validator_value
    schema: Any = error.schema
    instance: Any = error.instance
    shown = repr(error.instance) if len(repr(error.instance)) < 60 else f"a {type(error.instance).__name__}"
    match error.validator:
        case "additionalProperties":
            known = ", ".join(sorted(schema.get("properties", {})))
            return "is not a known key", f"known here: {known}" if known else "remove it"
        case "type":
            kinds = limit if isinstance(limit, str) else " or ".join(limit)
            return f"is {shown}", f"give a value of type {kinds}"
        case "enum":
            return f"is {shown}", f"give one of {', '.join(map(str, limit))}"
        case "minimum" | "exclusiveMinimum":
            return (
                f"is {shown}",
                f"give a value {'of at least' if error.validator == 'minimum' else 'above'} {limit}",
            )
        case "maximum" | "exclusiveMaximum":
            return (
                f"is {shown}",
                f"give a value {'of at most' if error.validator == 'maximum' else 'below'} {limit}",
            )
        case "pattern":
            return f"is {shown}", f"give text that matches {limit}"
        case "minItems" | "maxItems" | "minProperties" | "maxProperties":
            side = "at least" if str(error.validator).startswith("min") else "at most"
            return "has a wrong number of entries", f"give {side} {limit}"
        case "required":
            missing = sorted(set(limit) - set(instance))
            return f"lacks {', '.join(missing)}", "add it"
        case _:
            described = schema.get("description", "") if isinstance(schema, Mapping) else ""
            return (
                f"is {shown}",
                f"give {described[:1].lower()}{described[1:]}" if described else "see its schema",
            )

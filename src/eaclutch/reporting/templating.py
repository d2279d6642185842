"""The pages' templates: one environment that escapes all text and refuses names it does not know."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from eaclutch.reporting.glance import set_words
from eaclutch.reporting.words import effect_words, number, observable_words, percent, plain, short, with_error

_TEMPLATES = Path(__file__).parent / "templates"


def environment() -> Environment:
    """Templates with the pages' filters; all text from a campaign is escaped."""
    found = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters |= {
        "number": number,
        "percent": percent,
        "observable": observable_words,
        "effects": effect_words,
        "set": set_words,
        "plain": plain,
        "short": short,
        "with_error": with_error,
    }
    return found


def style() -> Markup:
    """The report's style sheet, to stand in the page itself."""
    return Markup((_TEMPLATES / "report.css").read_text(encoding="utf-8"))

"""Names, numbers and units as people read them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

FACTORS = {
    "voltage_v": "voltage (V)",
    "frequency_hz": "drive frequency (Hz)",
    "width_mm": "substrate width (mm)",
    "thickness_mm": "substrate thickness (mm)",
    "preload_n": "preload (N)",
    "session": "session",
    "run_order": "order in the session",
    "dwell_s": "rest before switch-off (s)",
    "all": "everywhere",
}
_UNIT_ENDINGS = ("_n_s", "_hz", "_s", "_n", "_v", "_mm", "_um", "_pf")
_PREFIXES = (
    (1e9, "G"),
    (1e6, "M"),
    (1e3, "k"),
    (1.0, ""),
    (1e-3, "m"),
    (1e-6, "µ"),
    (1e-9, "n"),
    (1e-12, "p"),
    (1e-15, "f"),
)
_NAMES = {
    "ramp_rate_early": "early ramp rate",
    "ramp_rate_late": "late ramp rate",
    "switch_off_force": "force at switch-off",
    "friction_before": "friction before the voltage",
}
_SCALED = {"s", "N", "m", "F", "Hz", "N/s", "N/m", "m/N", "Pa", "ohm"}
_POWERS = str.maketrans("-0123456789.", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹·")


def observable_words(name: str) -> str:
    """``release_time_90_s`` as ``90 % release time``; other names without unit and underscores."""
    for ending in _UNIT_ENDINGS:
        if name.endswith(ending):
            name = name.removesuffix(ending)
            break
    if name.startswith("release_time_"):
        return f"{name.removeprefix('release_time_')}\u00a0% release time"
    return _NAMES.get(name, name.replace("_", " "))


def unit_words(unit: str | None) -> str:
    """``N m^-3.5`` as ``N m⁻³·⁵``, ``m2/V2`` as ``m²/V²``, ``ohm`` as ``Ω``, nothing for 1."""
    if unit in (None, "", "1"):
        return ""
    if unit == "ohm":
        return "Ω"
    unit = re.sub(r"^u(?=[sm])", "µ", unit)
    return re.sub(r"(?<=[A-Za-z])\^?(-?\d[\d.]*)", lambda power: power[1].translate(_POWERS), str(unit))


def effect_words(names: Iterable[str]) -> str:
    """A set of effects as text: ``trapped charge and film tension``, ``no effect``, ``an unknown effect``."""
    names = list(names)
    if not names:
        return "no gap"
    if names == ["unknown"]:
        return "an effect outside the library"
    return " and ".join(name.replace("_", " ") for name in names)


def holds_the_pair(names: Sequence[str], pair: Sequence[str]) -> bool:
    """Whether a set of three holds the pair that a verdict names."""
    return len(names) > 2 and len(pair) == 2 and set(names) > set(pair)


def superscript(power: float) -> str:
    """``-7`` as ``⁻⁷``."""
    return f"{power:g}".translate(_POWERS)


@dataclass(frozen=True)
class Scale:
    """What to multiply SI values with to show them, and the unit then."""

    factor: float
    unit: str

    def __call__(self, values: ArrayLike) -> np.ndarray:
        return np.asarray(values, dtype=float) * self.factor


def scale_for(values: ArrayLike, unit: str) -> Scale:
    """A prefix that brings typical values near 1 to 1000; units that take none stay."""
    sizes = np.abs(np.asarray(values, dtype=float))
    sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
    if unit == "kg" and len(sizes) and np.median(sizes) < 1:
        return Scale(1e3, "g")
    shown = unit_words(unit)
    if unit not in _SCALED or not len(sizes):
        return Scale(1.0, shown)
    typical = float(np.median(sizes))
    for size, prefix in _PREFIXES:
        if typical >= size:
            return Scale(1 / size, f"{prefix}{shown}")
    return Scale(1.0, shown)


def number(value: float | None, digits: int = 3) -> str:
    """A number at a few significant digits with a true minus; a dash where there is none."""
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if exponent >= 5 or exponent < -4:
        mantissa = f"{value / 10.0**exponent:.{digits - 1}f}".rstrip("0").rstrip(".")
        return f"{mantissa}·10{superscript(exponent)}".replace("-", "−")
    decimals = max(digits - 1 - exponent, 0)
    return f"{value:.{decimals}f}".replace("-", "−")


def plain(value: float | None) -> str:
    """A setting as one writes it: 300, 0.1, 10000; a dash where there is none."""
    return number(value) if value is None or not math.isfinite(value) else f"{value:.6g}".replace("-", "−")


def short(value: float, digits: int = 4) -> str:
    """A number as a table shows it, without trailing zeros: 1e4 as 10000."""
    text = f"{value:.{digits}g}"
    if "e" in text:
        mantissa, _, exponent = text.partition("e")
        text = f"{value:.0f}" if 0 <= int(exponent) < 6 else f"{mantissa}·10{superscript(int(exponent))}"
    return text.replace("-", "−")


def with_error(mean: float | None, sd: float | None, unit: str | None = "") -> str:
    """``120 ± 15 µm/N``: both to the error's second digit; an error of zero was not found, and that is said."""
    if mean is None or not math.isfinite(mean):
        return "–"
    scale = scale_for([mean], unit or "1")
    value = float(scale(mean))
    if not sd or not math.isfinite(sd):
        return f"{number(value)} {scale.unit}".strip() + (" (no uncertainty found)" if sd == 0 else "")
    error = float(scale(sd))
    power = math.floor(math.log10(max(abs(value), error)))
    power = power if power >= 5 or power < -3 else 0
    value, error = value / 10.0**power, error / 10.0**power
    decimals = max(1 - math.floor(math.log10(error)), 0)
    text = f"{value:.{decimals}f} ± {error:.{decimals}f}".replace("-", "−")
    if power:
        text = f"({text})·10{superscript(power)}"
    return f"{text} {scale.unit}".strip()


def percent(share: float | None) -> str:
    """A share as percent; never 0 % or 100 % for what is neither."""
    if share is None or not math.isfinite(share):
        return "–"
    if 0 < share < 0.01:
        return "< 1\u00a0%"
    if 0.99 < share < 1:
        return "> 99\u00a0%"
    return f"{100 * share:.0f}\u00a0%".replace("-", "−")


def measured(value: float | None, low: float | None, high: float | None, unit: str = "") -> str:
    """``value (low to high) unit``."""
    text = number(value)
    if low is not None and high is not None:
        text += f" ({number(low)} to {number(high)})"
    return f"{text} {unit}".strip()

"""Whether the operator set what the plan says, as far as the sensed electrode can tell."""

from __future__ import annotations

import numpy as np

from eaclutch.records import DC_LABEL
from eaclutch.rig.link.protocol import BenchSetting, Columns
from eaclutch.rig.link.transfer import TransferFault

SENSED_HIGH = 50.0  # V
# Below, too few edges fall into a drive; above, the sampling does not resolve them.
_FREQUENCIES = (2.0, 2000.0)
_FREQUENCY_TOLERANCE = 0.2
_SHORTEST_DRIVE = 5.0  # periods


def check_setting(
    columns: Columns, setting: BenchSetting, voltage_tolerance: float
) -> dict[str, float | None]:
    """Sensed amplitude [V] and drive frequency [Hz], None where they cannot be told.

    Raises TransferFault ``wrong_voltage`` or ``wrong_frequency``: the run is sound but another condition's.
    """
    driven = columns.flag > 0.5
    sensed = columns.voltage[driven]
    high = sensed > SENSED_HIGH
    duration = float(np.count_nonzero(driven)) * float(np.median(np.diff(columns.time_us))) * 1e-6
    found: dict[str, float | None] = {"sensed_voltage_v": None, "sensed_frequency_hz": None}
    if high.any():
        found["sensed_voltage_v"] = amplitude = float(np.median(sensed[high]))
        if abs(amplitude - setting.voltage) > voltage_tolerance * setting.voltage:
            raise TransferFault(
                "wrong_voltage", f"{amplitude:.0f} V are sensed, the plan says {setting.voltage:g} V"
            )
    elif setting.voltage > 2 * SENSED_HIGH and duration > 1.5 / setting.frequency:
        # slower than this, the sensed electrode may be the one at ground all the time
        raise TransferFault("wrong_voltage", f"no voltage is sensed, the plan says {setting.voltage:g} V")
    slowest, fastest = _FREQUENCIES
    if (
        high.any()
        and slowest <= setting.frequency <= fastest
        and duration * setting.frequency >= _SHORTEST_DRIVE
    ):
        rises = np.flatnonzero(np.diff(high.astype(int)) > 0)
        if len(rises) < 3:
            raise TransferFault(
                "wrong_frequency", f"the voltage does not alternate, the plan says {setting.frequency:g} Hz"
            )
        span = (rises[-1] - rises[0]) / len(high) * duration
        found["sensed_frequency_hz"] = frequency = float((len(rises) - 1) / span)
        if abs(frequency - setting.frequency) > _FREQUENCY_TOLERANCE * setting.frequency:
            what = f"{frequency:.3g} Hz are sensed, the plan says {setting.frequency:g} Hz"
            raise TransferFault("wrong_frequency", what)
    elif setting.frequency <= DC_LABEL and np.count_nonzero(np.diff(high.astype(int)) > 0) > 1:
        raise TransferFault("wrong_frequency", "the voltage alternates, the plan says DC")
    return found

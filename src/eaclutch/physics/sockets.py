"""Sockets: the plain numbers per run that the compiled solver understands.

An effect fills sockets from run conditions and its parameters; the solver never learns an effect's name.
Every field broadcasts to (draws, runs). The defaults are neutral: they are what is left when no effect is on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from eaclutch.records import FloatArray

LARGEST_RESIDUAL = 0.98  # of the drive's field, that an effect leaves behind


@dataclass(frozen=True)
class Sockets:
    """Neutral defaults; SI units. V0 is the run's drive amplitude, t counts from switch-off."""

    # drive
    rise_time_constant: FloatArray | float = 0.0  # s; 0 = step
    fall_time_constant: FloatArray | float = 0.0  # s; 0 = step
    edge_straightness: FloatArray | float = 0.0  # 0: exponential edges, 1: straight ones
    drive_delay: FloatArray | float = 0.0  # s; between the logged edge and the film's, both edges
    field_lag: FloatArray | float = (
        0.0  # s; by which the edge lags beyond the drive's own: dipoles keep up with it
    )
    # dielectric: kappa while driven, and how it relaxes after a change of the field
    kappa_driven: FloatArray | float = np.nan  # NaN = kappa_static
    relaxing: FloatArray | float = 0.0  # 1: Cole-Cole history after each edge, 0: kappa constant
    saturation_ratio: FloatArray | float = 0.0  # kappa -> kappa (1 + ratio (V/V0)^2)^(-1/3)
    thinning_ratio: FloatArray | float = 0.0  # film thickness -> T_d (1 - ratio (V/V0)^2)
    # electrostatics
    gap_in_force: FloatArray | float = 0.0  # weight w: F = (1 - w) bare film + w with the gap
    roughness_in_force: FloatArray | float = (
        0.0  # weight w: F = (1 - w) flat gap + w averaged (the model's rule)
    )
    force_factor: FloatArray | float = 1.0  # multiplies F_ea beside force_multiplier
    held_factor: FloatArray | float = (
        1.0  # multiplies F_ea once more at the end of the hold, where it is released
    )
    residual_fraction: FloatArray | float = (
        0.0  # residual field: V_res = fraction V0 exp(-t / residual_decay_time), at the driven kappa; the rest of
        # V0^2, (1 - fraction^2), falls with the drive, so the force is continuous at switch-off
    )
    residual_decay_time: FloatArray | float = 1.0  # s
    # contact
    contact_factor: FloatArray | float = 1.0  # multiplies contact_stiffness
    gap_spread_sd: FloatArray | float = 0.0  # m; of an even spread of the gaps over the overlap (tilt)
    gap_levelling: FloatArray | float = 0.0  # 1/N; how much closeness makes that spread smaller
    gap_in_air: FloatArray | float = 0.0  # share of that spread that the squeezed air sees
    fixture_gap_spread_sd: FloatArray | float = 0.0  # m; the same on the capacitance fixture
    adhesion_force: FloatArray | float = 0.0  # N at full contact; acts as adhesion_force * ..
    fixture_adhesion_force: FloatArray | float = (
        0.0  # N; the same on the capacitance fixture, of the pad's area
    )
    adhesion_range: FloatArray | float = 1.0  # .. Phi(-h / (adhesion_range sigma)), ..
    adhesion_separating: FloatArray | float = 1.0  # .. so many times as much from switch-off on
    # film
    film_weight: FloatArray | float = 0.0  # N; m_d g
    damping_factor: FloatArray | float = 0.0  # multiplies the squeeze-film coefficient; 0 = no squeeze film
    slip_length: FloatArray | float = 0.0  # m; F_b = -c / (h^2 (h + 6 slip_length)) dh/dt
    film_spring: FloatArray | float = (
        0.0  # N/m; carries film_spring * (f(y) - f(y_before)) of the load, f(y) = y (1 + film_hardening y^2), ..
    )
    film_hardening: FloatArray | float = 0.0  # 1/m2; .. y = y_before + h_before - h, ..
    film_free_gap: FloatArray | float = 0.0  # m; .. y_before = film_free_gap - h_before, no less than 0
    # friction
    friction_factor: FloatArray | float = (
        1.0  # multiplies all four coefficients throughout (the preload follows from the same friction)
    )
    side_friction: FloatArray | float = 0.0  # N kinetic, beside base and film, while sliding
    side_friction_static: FloatArray | float = 0.0  # N static
    side_pull: FloatArray | float = (
        0.0  # N kinetic, more of it while the voltage is on (static in the film's ratio)
    )
    side_damping: FloatArray | float = 0.0  # kg/s, viscous, while the tip pushes
    softening: FloatArray | float = (
        0.0  # 1/N; the driven friction F becomes F / (1 + (softening F)^n)^(1 / n), ..
    )
    softening_power: FloatArray | float = 1.0  # .. n
    contact_lag: FloatArray | float = 0.0  # s; after switch-off a share of the film's friction follows ..
    contact_lag_share: FloatArray | float = (
        0.0  # .. its contact force F_k by L' = (F_k - L) / (contact_lag (F_k0 / 1 N)^power), ..
    )
    contact_lag_power: FloatArray | float = 0.0  # .. F_k0 the one that is released
    static_factor_release: FloatArray | float = (
        1.0  # multiplies the static coefficients at switch-off (rest = dwell)
    )
    static_factor_ramp: FloatArray | float = 1.0  # multiplies them during the driven ramp
    # (the friction before is measured at stage speed: the preload accounts for the factor there)
    weakening_depth: FloatArray | float = 0.0  # mu_k -> mu_k (1 - depth (1 - exp(-|v| / weakening_speed)))
    weakening_speed: FloatArray | float = 1.0  # m/s
    # load train
    load_cell_dynamic: FloatArray | float = (
        0.0  # 1: mass-spring-damper, 0: the reading follows the friction; no between
    )
    added_mass: FloatArray | float = 0.0  # kg; moves with the tip while it pushes
    series_compliance: FloatArray | float = 0.0  # m/N; in series with the load cell while the tip pushes
    film_compliance: FloatArray | float = 0.0  # m/N; beside it while the strip sticks: of the film, in shear
    stage_speed_factor: FloatArray | float = 1.0  # multiplies the stage's speed
    # readout
    readout_time: FloatArray | float = 0.0  # s; time constant of a low pass between the force and its log
    reading_drift: FloatArray | float = 0.0  # N/s; rate at which the zero of the reading moves while driven
    # capacitance bench
    stray_capacitance: FloatArray | float = 0.0  # F; parallel to the pad on the fixture

    def with_(self, **changes: Any) -> Sockets:
        """A copy with some sockets replaced; an unknown name is an error."""
        return replace(self, **changes)

    def with_residual_pull(self, share: FloatArray, decay_time: FloatArray | float) -> Sockets:
        """A copy in which so large a share [1] of the pull at switch-off outlives it, beside what does already, and
        fades in ``decay_time`` [s]. There is one residual field: both decay with the mean of the logarithms of their
        times, weighted by what they pull."""
        others = np.square(self.residual_fraction)  # a field's square pulls
        more = share * (1.0 - others)
        weight = more / np.maximum(others + more, np.finfo(float).tiny)
        times = np.asarray(self.residual_decay_time), 2.0 * np.asarray(decay_time)
        return self.with_(
            residual_fraction=np.sqrt(others + more),
            residual_decay_time=times[0] ** (1.0 - weight) * times[1] ** weight,
        )

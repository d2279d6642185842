"""One simulation's numbers as a record: what the compiled solver knows of a draw and a run (SI units)."""

from __future__ import annotations

import numpy as np

# Names follow sockets.py and the calibrated parameters; what differs is said here.
ROW = np.dtype(
    [
        (name, np.float64)
        for name in (
            # drive
            "voltage", "rise_time_constant", "fall_time_constant", "edge_straightness", "drive_delay",
            # dielectric
            "kappa_driven", "kappa_infinity", "relaxing", "relaxation_time", "exponent", "saturation_ratio",
            "thinning_ratio", "thickness",
            # electrostatics: force_scale = Q lambda force_factor; clamped 1 or 0; cut of the published rule
            "force_scale", "held_factor", "gap_in_force", "roughness_in_force", "clamped", "cut",
            "residual_fraction", "residual_decay_time",
            # contact: contact_scale = k L w sigma^1.5, sigma the roughness; gap_half_spread [m] of an even
            # spread, gap_levelling [1/N] that makes it smaller, gap_in_air the share that the air sees
            "contact_scale", "contact_law_bend", "sigma", "inverse_sigma", "gap_half_spread", "gap_levelling",
            "gap_in_air", "adhesion_force", "adhesion_range", "adhesion_separating",
            # film: damping [N s m2] so that F_b = -damping / (h^2 (h + 6 slip_length)) dh/dt
            "film_mass", "film_weight", "damping", "slip_length", "film_spring", "film_hardening", "film_free_gap",
            # friction
            "film_static", "film_kinetic", "base_static", "base_kinetic", "substrate_weight", "side_friction",
            "side_friction_static", "side_pull", "side_damping", "softening", "softening_power",
            "contact_lag", "contact_lag_share", "contact_lag_power",
            "static_factor_release", "static_factor_ramp", "weakening_depth", "weakening_speed",
            # load train
            "stiffness", "mass", "load_cell_damping", "load_cell_dynamic", "added_mass", "series_compliance",
            "film_compliance",
            # readout
            "readout_time", "reading_drift",
            # run
            "friction_before", "switch_off_force", "slip_phase", "drive_duration", "dwell", "stage_speed",
        )
    ]
)  # fmt: skip

"""Preload of a run from the friction before the voltage (physics.md 9)."""

from __future__ import annotations

from eaclutch.records import Bench, InputError, RunSettings, Substrate
from eaclutch.rig.log_names import STANDARD_GRAVITY


def substrate_of(settings: RunSettings, bench: Bench) -> tuple[Substrate, float]:
    """The run's substrate and its thickness [m]. Raises InputError where campaign.yaml does not know them."""
    known = bench.substrates or {"brass": Substrate()}
    substrate = known.get(settings.substrate)
    if substrate is None:
        what = f"substrate {settings.substrate} is not known"
        raise InputError(
            "campaign.yaml, substrates", what, f"add {settings.substrate} with density and thickness"
        )
    for width, thickness in substrate.thickness.items():
        if abs(width - settings.width) < 1e-6:
            return substrate, thickness
    return substrate, settings.width  # square bars unless the bench says otherwise


def weights_of(settings: RunSettings, bench: Bench) -> tuple[float, float]:
    """Weight of the substrate and of the film [N]."""
    substrate, thickness = substrate_of(settings, bench)
    substrate_mass = substrate.density * substrate.length * settings.width * thickness + substrate.extra_mass
    area = bench.pad.overlap_length * settings.width
    film_mass = bench.film_density * bench.pad.film_thickness * area
    return substrate_mass * STANDARD_GRAVITY, film_mass * STANDARD_GRAVITY


def preload_of(friction_before: float, settings: RunSettings, bench: Bench) -> float:
    """Preload [N] from the friction before the voltage [N]; kinetic coefficients. May be slightly negative."""
    substrate_weight, film_weight = weights_of(settings, bench)
    base, film = bench.friction.base_kinetic.mean, bench.friction.film_kinetic.mean
    return (friction_before - base * substrate_weight - film * film_weight) / (film + base)

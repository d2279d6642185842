"""Readers of campaign.yaml and of the config: closed schemas, defaults in one place, one error line."""

from eaclutch.config.bench import load_bench
from eaclutch.config.settings import effect_names, load_config

__all__ = ["effect_names", "load_bench", "load_config"]

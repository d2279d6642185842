"""Campaigns that want to do harm, each as a function that builds its folder: one file a kind of harm."""

from hostile_campaigns import facts, logs, names_and_links, side_files, workbooks
from hostile_campaigns.sound import CASES

__all__ = ["CASES", "facts", "logs", "names_and_links", "side_files", "workbooks"]

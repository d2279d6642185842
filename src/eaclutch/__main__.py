"""``python -m eaclutch`` is the command ``eaclutch``."""

from eaclutch.cli import main

main()

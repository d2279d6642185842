"""The tiny campaign with a config of short chains."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from workflow.tiny import QUICK, tiny_campaign


@pytest.fixture(scope="session")
def quick(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A config of short chains that points at a tiny campaign beside it."""
    folder = tmp_path_factory.mktemp("campaigns")
    tiny_campaign(folder / "tiny")
    path = folder / "quick.yaml"
    path.write_text(yaml.safe_dump(QUICK | {"campaign": "tiny"}))
    return path

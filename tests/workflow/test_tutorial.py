"""Every command of docs/first-campaign.md, run as it stands there."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from workflow.tiny import QUICK, ROOT

pytestmark = [pytest.mark.workflow, pytest.mark.timeout(1500)]


def test_the_commands_of_the_first_campaign_work(tmp_path: Path) -> None:
    """In a copy of the checkout's working parts; sampling is shortened further, the commands are not touched."""
    for name in ("Snakefile", "workflow", "config"):
        source = ROOT / name
        shutil.copytree(source, tmp_path / name) if source.is_dir() else shutil.copy(source, tmp_path / name)
    shutil.copytree(ROOT / "data", tmp_path / "data", ignore=shutil.ignore_patterns("fixture-null", "logs"))
    for path in sorted((tmp_path / "data" / "fixture" / "tensile").iterdir())[8:]:
        path.unlink()
    (tmp_path / "config" / "quick.yaml").write_text(yaml.safe_dump(QUICK))
    text = (ROOT / "docs" / "first-campaign.md").read_text()
    commands = "\n".join(re.findall(r"```sh\n(.*?)```", text, flags=re.DOTALL))
    assert "snakemake" in commands and "verify" in commands
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", commands],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env=os.environ | {"PATH": path},
    )
    assert done.returncode == 0, done.stderr[-5000:]
    assert "all results and inputs stand" in done.stdout
    html = (tmp_path / "results" / "rehearsal" / "report.html").read_text()
    assert "No usable data for the dielectric" in html

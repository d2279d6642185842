"""The page in a real browser: nothing wider than the screen, every figure drawn, no error."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from eaclutch.reporting.page import render
from eaclutch.reporting.results import read_results

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
SCREENSHOTS = Path(__file__).resolve().parents[2] / "build" / "screenshots"
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--virtual-time-budget=4000",
    "--enable-logging=stderr",
)
# Scrolling boxes may hold what is wider than the screen; nothing else may.
PROBE = """<script>
window.addEventListener("load", () => {
  document.documentElement.style.width = "WIDTHpx";
  document.querySelectorAll("details").forEach(item => item.open = true);
  const wide = [], flat = [];
  document.querySelectorAll("body *").forEach(item => {
    const box = item.getBoundingClientRect();
    if (box.right > WIDTH + 1 && !item.closest(".wide, pre, svg")) wide.push(item.tagName + "." + item.className);
  });
  document.querySelectorAll("figure svg").forEach(item => {
    const box = item.getBoundingClientRect();
    if (box.height < 40 || box.width < 100) flat.push(item.closest("figure").id);
  });
  const figures = document.querySelectorAll("figure svg").length;
  document.title = "PROBE" + JSON.stringify({wide: wide.slice(0, 5), flat: flat, figures: figures});
});
</script></body>"""


@pytest.mark.skipif(BROWSER is None, reason="no chromium")
@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_is_wider_than_the_screen(results_folder: Path, tmp_path: Path, width: int) -> None:
    html = render(read_results(results_folder), {"seed": 1})
    page = tmp_path / "page.html"
    page.write_text(html.replace("</body>", PROBE.replace("WIDTH", str(width))))
    command = [
        str(BROWSER),
        *FLAGS,
        f"--user-data-dir={tmp_path / 'profile'}",
        f"--window-size={width},900",
        "--dump-dom",
    ]
    # looked at after a change of the page: build/screenshots
    shown = SCREENSHOTS / f"report-{width}.png"
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    subprocess.run([*command[:-1], f"--screenshot={shown}", page.as_uri()], capture_output=True, timeout=240)
    assert shown.stat().st_size > 20_000
    done = subprocess.run([*command, page.as_uri()], capture_output=True, text=True, timeout=240)
    found = re.search(r"<title>PROBE(\{.*?\})</title>", done.stdout)
    assert found, done.stderr[-2000:]
    seen = json.loads(found.group(1))
    assert seen["wide"] == [] and seen["flat"] == []
    assert seen["figures"] == html.count("<figure")
    assert "CONSOLE" not in done.stderr

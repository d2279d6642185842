"""The command line: every command has help, errors are one line."""

from __future__ import annotations

import errno
import subprocess
import sys
from pathlib import Path

import click
import pytest

from eaclutch.cli import group


def paths() -> list[tuple[str, ...]]:
    found: list[tuple[str, ...]] = []
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        found.append((name,))
        if isinstance(command, click.Group):
            found += [(name, inner) for inner in command.list_commands(click.Context(command))]
    return found


@pytest.mark.parametrize("path", paths(), ids=" ".join)
def test_every_command_has_help(path: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    from eaclutch.cli import main

    with pytest.raises(SystemExit) as stop:
        main([*path, "--help"])
    assert stop.value.code == 0
    text = capsys.readouterr().out
    assert "Usage:" in text and len(text.splitlines()) > 4


def test_names_of_commands_are_unique() -> None:
    names = group.list_commands(click.Context(group))
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    "arguments",
    [
        ["no-such-command"],
        ["capture", "--campaign", "nowhere", "--output", "x.json"],
        ["capture"],
        ["verify", "nowhere"],
        [
            "predict",
            "--campaign",
            ".",
            "--results",
            ".",
            "--output",
            "x.csv",
            "--settings",
            "{",
        ],
        ["posterior", "contact", "--campaign", ".", "--results", ".", "--output", "x.nc", "--gate", "g.json"],
        ["manifest", "--results", "nowhere", "--output", "x.json"],
        ["blind", "report", "--score", "damaged.json", "--newest", "n.html", "--output", "x.html"],
        ["blind", "report", "--score", "list.json", "--newest", "n.html", "--output", "x.html"],
        ["fea", "--campaign", "damaged.json", "--table", "t", "--insulators", "i", "--page", "p"],
    ],
    ids=" ".join,
)
def test_an_error_is_one_line_and_a_status(arguments: list[str], tmp_path: Path) -> None:
    (tmp_path / "damaged.json").write_bytes(b"\xff\x00{")
    (tmp_path / "list.json").write_text("[1]")
    done = subprocess.run(
        [sys.executable, "-m", "eaclutch", *arguments], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 1
    assert done.stdout == ""
    lines = done.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith("eaclutch: error: ")


def test_with_a_log_the_error_goes_there(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "eaclutch", "--log", "logs/a.log", "verify", "nowhere"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 1 and done.stderr == ""
    assert (tmp_path / "logs" / "a.log").read_text().startswith("eaclutch: error: nowhere/manifest.json")


def test_a_full_disk_is_one_line_too(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys) -> None:
    from eaclutch.cli import main

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", str(tmp_path / "out.md"))

    monkeypatch.setattr("eaclutch.files.atomic", full)
    with pytest.raises(SystemExit) as stop:
        main(["config-readme", "--output", str(tmp_path / "out.md")])
    assert stop.value.code == 1
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and "No space left on device; make room" in line
    log = tmp_path / "a.log"
    with pytest.raises(SystemExit):
        main(["--log", str(log), "config-readme", "--output", str(tmp_path / "out.md")])
    assert "No space left on device; make room" in log.read_text()

"""Names with a meaning to a shell or a browser; links, pipes and folders in a file's place."""

from __future__ import annotations

import os
from pathlib import Path

from hostile_campaigns.sound import NAME, base, case, sound_log


@case
def name_with_html(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME}<img src=x onerror=alert(1)>.csv").write_text(sound_log())


@case
def name_with_shell(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME[:-5]}$(touch canary)`touch canary`;touch canary;.csv").write_text(
        sound_log()
    )


@case
def name_with_newline(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME}\neaclutch: error: nothing is wrong.csv").write_text(sound_log())


@case
def name_with_absurd_numbers(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME.replace('V=300', 'V=1e999')}.csv").write_text(sound_log())


@case
def side_file_with_shell_name(folder: Path) -> None:
    base(folder)
    text = "force_n,capacitance_pf,width_mm,trial\n" + "0.1,20,2,$(touch canary)\n0.2,21,2,<script>\n"
    (folder / "capacitance" / "a;touch canary;$(touch canary).csv").write_text(text)


@case
def log_is_a_link_out(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME.replace('10_00_00', '11_00_00')}.csv").symlink_to("/etc/passwd")


@case
def folder_is_a_link_out(folder: Path) -> None:
    base(folder, log=False)
    other = folder.with_name("other")
    base(other)
    (folder / "tensile").rmdir()
    (folder / "tensile").symlink_to(other / "tensile")


@case
def facts_are_a_link_out(folder: Path) -> None:
    base(folder)
    (folder / "campaign.yaml").unlink()
    (folder / "campaign.yaml").symlink_to("/etc/passwd")


@case
def link_to_itself(folder: Path) -> None:
    base(folder)
    path = folder / "tensile" / f"{NAME.replace('10_00_00', '11_00_00')}.csv"
    path.symlink_to(path)


@case
def log_is_a_pipe(folder: Path) -> None:
    base(folder)
    os.mkfifo(folder / "tensile" / f"{NAME.replace('10_00_00', '11_00_00')}.csv")
    os.mkfifo(folder / "capacitance" / "pipe.csv")


@case
def facts_are_a_pipe(folder: Path) -> None:
    base(folder)
    (folder / "campaign.yaml").unlink()
    os.mkfifo(folder / "campaign.yaml")


@case
def log_is_a_folder(folder: Path) -> None:
    base(folder)
    (folder / "tensile" / f"{NAME.replace('10_00_00', '11_00_00')}.csv").mkdir()

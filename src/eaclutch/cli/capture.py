"""From the live rig into a campaign, and the check of a plan against what the campaign holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import click
import numpy as np
import yaml
from tqdm import tqdm

from eaclutch.config import load_bench
from eaclutch.config.slices import parse_settings
from eaclutch.files import read_json, write_text
from eaclutch.manifest import write_capture
from eaclutch.records import Bench, InputError, Recording
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.link.emulator import turn_knobs
from eaclutch.rig.link.plan import Plan, Slot, make_plan, read_plan
from eaclutch.rig.link.protocol import BenchSetting
from eaclutch.rig.link.reader import SerialLink
from eaclutch.rig.link.session import Operator, Unattended, describe, run_session
from eaclutch.rig.link.store import CampaignStore, captured_runs, missing_slots
from eaclutch.rig.link.suggest import plan_from_suggestions
from eaclutch.rig.link.transfer import TransferFault
from eaclutch.rig.log_names import log_name

_FOLDER = click.Path(file_okay=False, path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)
_SIMULATED_FROM = datetime(2025, 1, 1, 9)
_SHOWN = (
    "shear_capacity_n",
    "engagement_time_s",
    "release_time_90_s",
    "release_time_10_s",
    "friction_before_n",
)


class _Console:
    """The operator at the terminal."""

    def change(self, before: BenchSetting | None, after: BenchSetting) -> None:
        if before is not None:
            changed = [name for name, value in vars(after).items() if getattr(before, name) != value]
            click.echo(f"change: {', '.join(changed)}")
        click.prompt(
            f"set {describe(after)}, then press Enter", default="", show_default=False, prompt_suffix=" "
        )

    def wrong(self, setting: BenchSetting, fault: TransferFault) -> None:
        click.prompt(
            f"{fault.detail}: mend it, then press Enter", default="", show_default=False, prompt_suffix=" "
        )


class _Knobs:
    """The operator of an emulated rig."""

    def __init__(self, port: str):
        self.port = port

    def change(self, before: BenchSetting | None, after: BenchSetting) -> None:
        turn_knobs(self.port, after)

    def wrong(self, setting: BenchSetting, fault: TransferFault) -> None:
        turn_knobs(self.port, setting)


class _Screen:
    """Shows how the session goes, and each run's picture and observables."""

    def __init__(self, bench: Bench, pictures: Path | None):
        self.bench, self.pictures = bench, pictures
        self.bar: tqdm | None = None

    def started(self, slot: Slot, done: int, total: int) -> None:
        if self.bar is None:
            self.bar = tqdm(total=total, unit="run", disable=None)
        self.bar.set_description(describe(slot.setting))

    def progress(self, phase: str, share: float) -> None:
        if self.bar is not None:
            self.bar.set_postfix_str(f"{phase} {share:4.0%}")

    def refused(self, slot: Slot, fault: TransferFault, attempt: int) -> None:
        tqdm.write(f"refused ({fault}), attempt {attempt + 1}")

    def finished(self, recording: Recording, path: Path, repairs: tuple[str, ...]) -> None:
        from eaclutch.rig.extract import extract

        if self.bar is not None:
            self.bar.update()
        try:
            row = extract(recording, self.bench)
        except InputError as error:  # the run is safe in the campaign; only its summary fails
            tqdm.write(f"{path.name}  no observables: {error}")
            return
        values = [
            f"{name}={row[name]:.4g}" for name in _SHOWN if row.get(name) == row.get(name, float("nan"))
        ]
        notes = [f"flags={row['flags']}"] if row["flags"] else []
        notes += [f"repaired={','.join(repairs)}"] if repairs else []
        tqdm.write("  ".join([path.name, *values, *notes]))
        if self.pictures is not None:
            self._picture(recording, path, "\n".join(values))

    def _picture(self, recording: Recording, path: Path, caption: str) -> None:
        from eaclutch.reporting.run_picture import run_picture

        assert self.pictures is not None
        self.pictures.mkdir(parents=True, exist_ok=True)
        named = replace(recording, settings=replace(recording.settings, run=path.name))
        run_picture(named, caption).savefig(self.pictures / f"{path.name}.png", dpi=110)


@click.command()
@click.option(
    "--plan",
    "plan_file",
    type=_FILE,
    required=True,
    help="What to capture (workflow/schemas/plan.schema.yaml).",
)
@click.option(
    "--campaign", type=_FOLDER, required=True, help="Folder with a campaign.yaml, to which runs are added."
)
@click.option(
    "--port", help="Path, pattern or usb:<vendor>:<product>[:<serial number>]; default: the one Teensy."
)
@click.option("--unattended", is_flag=True, help="Never ask; stop where something would have to be changed.")
@click.option(
    "--emulated", is_flag=True, help="The port is that of eaclutch emulate, whose knobs are turned too."
)
@click.option("--speed-factor", type=float, help="How much faster than the bench an emulated rig runs.")
@click.option(
    "--pictures/--no-pictures", default=True, show_default=True, help="Draw each run into <campaign>.capture."
)
def capture(
    plan_file: Path, campaign: Path, port: str | None, unattended: bool, emulated: bool,
    speed_factor: float | None, pictures: bool,
) -> None:  # fmt: skip
    """Capture what a campaign lacks of a plan. Stop it at any time (Ctrl-C) and start it again to go on."""
    plan = with_speed(read_plan(plan_file), speed_factor)
    if emulated and port is None:
        raise InputError(
            "capture --emulated", "no port is named", "give the --link of eaclutch emulate as --port"
        )
    operator: Operator = _Knobs(str(port)) if emulated else Unattended() if unattended else _Console()
    with CampaignStore(campaign) as store:
        bench = load_bench(campaign)
        screen = _Screen(bench, store.aside / "pictures" if pictures else None)
        with SerialLink(f"{port}*" if emulated else port, plan.timing, plan.link) as link:
            try:
                summary = run_session(plan, store, link, operator, screen, bench.exclude)
            except KeyboardInterrupt:
                click.echo("stopped; the same command goes on with what is missing", err=True)
                raise click.Abort from None
    click.echo(f"{len(summary.finished)} runs captured, {summary.refused} transfers refused")
    if summary.failed:
        what = f"{len(summary.failed)} runs failed {plan.retries + 1} times each"
        raise InputError("capture", what, f"see {store.aside / 'refused'}, mend the link and capture again")


def with_speed(plan: Plan, speed_factor: float | None) -> Plan:
    """The plan for a rig that runs faster than the bench."""
    return plan if speed_factor is None else replace(plan, link=replace(plan.link, speed_factor=speed_factor))


def say_missing(plan: Plan, plan_file: Path, campaign: Path, excluded: Mapping[str, str]) -> None:
    """Raise InputError that names what the campaign lacks of the plan."""
    missing = missing_slots(plan, campaign, excluded)
    if missing:
        counts: dict[str, int] = {}
        for slot in missing:
            counts[describe(slot.setting)] = counts.get(describe(slot.setting), 0) + 1
        shown = [f"{count} x {what}" for what, count in counts.items()]
        listed = "; ".join(shown[:4]) + (
            f"; and {len(shown) - 4} further conditions" if len(shown) > 4 else ""
        )
        remedy = f"run eaclutch capture --plan {plan_file} --campaign {campaign}"
        raise InputError(
            plan_file, f"{len(missing)} of {len(plan.slots)} runs are missing ({listed})", remedy
        )


@click.command("capture-check")
@click.option("--campaign", type=_FOLDER, required=True, help="The campaign's folder.")
@click.option(
    "--settings", default="{}", help="JSON with the config's capture part and observables.batch_size."
)
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of the simulated rig."
)
@click.option("--output", type=_FILE, required=True, help="capture.json.")
def capture_check(campaign: Path, settings: str, seed: int, output: Path) -> None:
    """Check a campaign, and the plan against it where one is named, and list it. Never asks.

    Where the settings say that the source is simulated, the simulated rig adds what is missing first.
    """
    chosen: dict[str, Any] = parse_settings(settings)
    source = chosen.get("capture", {}).get("source", "recordings")
    plan_file = chosen.get("capture", {}).get("plan")
    if source != "recordings" and not plan_file:
        raise InputError(
            "capture.plan", f"is not there, source {source} needs one", "name a plan (config/plan.yaml)"
        )
    if source == "simulated":
        _simulate(read_plan(Path(plan_file)), campaign, chosen["capture"].get("effects", {}), seed)
    if plan_file:
        say_missing(read_plan(Path(plan_file)), Path(plan_file), campaign, load_bench(campaign).exclude)
    write_capture(open_campaign(campaign), chosen.get("observables.batch_size", 24), output)


def _simulate(plan: Plan, campaign: Path, effects: Mapping[str, Mapping[str, float]], seed: int) -> None:
    """Let the simulated rig add what the campaign lacks of the plan; each run has its own seed and stamp."""
    from eaclutch.physics.effects import BASE
    from eaclutch.simulation.live import LiveBench

    bench = load_bench(campaign)
    missing = set(missing_slots(plan, campaign, bench.exclude))
    if not missing:
        return
    values = {f"{effect}.{name}": value for effect, own in effects.items() for name, value in own.items()}
    live = LiveBench(bench, (*BASE, *effects), values, plan.timing, np.random.default_rng(seed))
    with CampaignStore(campaign) as store:
        for number, slot in enumerate(plan.slots):
            if slot in missing:
                recording = live.record(
                    slot.setting, slot.command, number, np.random.default_rng([seed, number])
                )
                name = log_name(slot.settings(_SIMULATED_FROM + timedelta(minutes=number)))
                record = {
                    "schema": 1,
                    "plan": plan.name,
                    "source": "simulated",
                    "effects": effects,
                    "seed": seed,
                }
                store.add(recording, name, plan.log_format, record)


@click.command("capture-plan")
@click.option(
    "--from", "diagnosis", type=_FILE, required=True, help="diagnosis.json, whose next_experiment is planned."
)
@click.option("--campaign", type=_FOLDER, required=True, help="The campaign that the runs are to join.")
@click.option("--substrate", help="Substrate of the runs; default: the campaign's only one.")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of the random order.")
@click.option("--output", type=_FILE, required=True, help="Plan to write; must not be there yet.")
def capture_plan(diagnosis: Path, campaign: Path, substrate: str | None, seed: int, output: Path) -> None:
    """Turn the next experiments that a diagnosis suggests into a plan."""
    if output.exists():
        raise InputError(output, "is there already", "name another file, or capture with that one")
    if substrate is None:
        names = sorted(load_bench(campaign).substrates)
        if len(names) != 1:
            raise InputError(campaign, f"has {len(names)} substrates", "choose one with --substrate")
        substrate = names[0]
    taken = {plan for plan in captured_runs(campaign).values() if plan}
    try:
        document = plan_from_suggestions(read_json(diagnosis), substrate, sorted(taken), seed)
    except (OSError, ValueError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(diagnosis, "is no readable diagnosis", "diagnose again") from None
    plan = make_plan(document, diagnosis)
    write_text(output, yaml.safe_dump(document, sort_keys=False))
    click.echo(f"{len(plan.slots)} runs planned in {output}")


COMMANDS = [capture, capture_check, capture_plan]

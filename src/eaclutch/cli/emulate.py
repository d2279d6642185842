"""The emulated rig for whoever wants to try without hardware."""

from __future__ import annotations

import signal
from pathlib import Path

import click
import numpy as np

from eaclutch.cli.capture import with_speed
from eaclutch.config import load_bench
from eaclutch.records import Bench, InputError, Recording
from eaclutch.rig.campaign import open_campaign
from eaclutch.rig.link.emulator import EmulatedRig, Source
from eaclutch.rig.link.faults import FAULTS, random_faults
from eaclutch.rig.link.plan import make_plan, read_plan
from eaclutch.rig.link.protocol import BenchSetting, Command, Timing
from eaclutch.rig.link.synthetic import SyntheticBench
from eaclutch.rig.logs import read_log


@click.command()
@click.option("--link", type=click.Path(path_type=Path), required=True, help="Name of the port to make.")
@click.option(
    "--campaign",
    type=click.Path(path_type=Path),
    required=True,
    help="Its campaign.yaml describes the bench.",
)
@click.option("--synthetic", is_flag=True, help="Send runs without physics: the link alone, at once.")
@click.option("--replay", is_flag=True, help="Send the campaign's own logs instead of simulated runs.")
@click.option(
    "--plan", "plan_file", type=click.Path(path_type=Path), help="Timing and speed as in this plan."
)
@click.option(
    "--effect",
    "effects",
    multiple=True,
    help="Effect to switch on beyond the base model, as <name> or <name>.<parameter>=<SI value>.",
)
@click.option("--speed-factor", type=float, help="How much faster than the bench; default: the plan's, or 1.")
@click.option(
    "--fault", "faults", multiple=True, type=click.Choice([*FAULTS, "any"]), help="Faults to draw from."
)
@click.option(
    "--fault-share", type=float, default=0.2, show_default=True, help="Part of the transfers with a fault."
)
@click.option("--bytes-per-second", type=float, help="Limit of the link.")
@click.option(
    "--journal",
    type=click.Path(path_type=Path),
    help="File that gets a JSON line a transfer, with its checksum.",
)
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of noise and faults.")
def emulate(
    link: Path, campaign: Path, replay: bool, synthetic: bool, plan_file: Path | None, effects: tuple[str, ...],
    speed_factor: float | None, faults: tuple[str, ...], fault_share: float, bytes_per_second: float | None,
    journal: Path | None, seed: int,
) -> None:  # fmt: skip
    """Start an emulated rig on a pseudo-terminal; Ctrl-C ends it."""
    rng = np.random.default_rng(seed)
    plan = with_speed(
        read_plan(plan_file) if plan_file else make_plan({"factors": {"voltage_v": [300]}}, "emulate"),
        speed_factor,
    )
    source: Source
    if synthetic:
        source = SyntheticBench(rng, plan.timing)
    elif replay:
        source = _Replay(campaign, rng)
    else:
        source = _simulated(load_bench(campaign), effects, plan.timing, rng)
    kinds = FAULTS if "any" in faults else faults
    rig = EmulatedRig(
        source,
        link,
        rng=rng,
        timing=plan.timing,
        speed_factor=plan.link.speed_factor,
        faults=random_faults(fault_share if faults else 0.0, rng, kinds or FAULTS),
        bytes_per_s=bytes_per_second,
        journal=journal,
    )
    source(
        plan.slots[0].setting, plan.slots[0].command
    )  # the first run compiles the model: not while one waits
    # also where a shell started it in the background, which has interrupts ignored
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    with rig:
        click.echo(f"the emulated rig answers on {link}")
        try:
            while not rig.ended.wait(0.2):
                pass
        except KeyboardInterrupt:
            click.echo(f"{len(rig.sent)} transfers sent")


class _Replay:
    """Logs of a campaign, drawn among those of the asked condition."""

    def __init__(self, campaign: Path, rng: np.random.Generator):
        self.logs, self.rng = open_campaign(campaign).logs, rng

    def __call__(self, setting: BenchSetting, command: Command) -> Recording:
        names = ("voltage", "frequency", "width", "substrate")
        wanted = [getattr(setting, name) for name in names]
        fitting = [log for log in self.logs if [getattr(log.settings, name) for name in names] == wanted]
        if not fitting:
            raise InputError(
                "emulate --replay", f"no log has {wanted}", "plan conditions that the campaign has"
            )
        return read_log(fitting[int(self.rng.integers(len(fitting)))].path)


def _simulated(bench: Bench, named: tuple[str, ...], timing: Timing, rng: np.random.Generator) -> Source:
    """The simulated rig with the base effects and those named."""
    from eaclutch.physics.effects import BASE, EFFECTS
    from eaclutch.simulation.live import LiveBench

    parameters: dict[str, float] = {}
    for item in named:
        key, _, value = item.partition("=")
        effect = key.split(".")[0]
        if effect not in EFFECTS:
            raise InputError(
                "--effect", f"there is no effect {effect!r}", f"give one of {', '.join(sorted(EFFECTS))}"
            )
        if value:
            try:
                parameters[key] = float(value)
            except ValueError:
                raise InputError(
                    "--effect", f"{item!r} is no <effect>.<parameter>=<number>", "give a number"
                ) from None
    effects = (*BASE, *sorted({item.partition("=")[0].split(".")[0] for item in named} - set(BASE)))
    return LiveBench(bench, effects, parameters, timing, rng)


COMMANDS = [emulate]

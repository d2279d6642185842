"""The command line: one module a room, a sub-command a rule. Modules are found by listing this folder."""

from __future__ import annotations

import importlib
import logging
import pkgutil
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from eaclutch.records import InputError

_LOG_FORMAT = "%(asctime)s %(levelname)s %(message)s"


class _Commands(click.Group):
    """All commands of the modules in this folder.

    Modules that name the wanted command are imported first and the rest only when it is not there: most commands
    do not need what the others import.
    """

    def _modules(self, name: str = "") -> list[str]:
        folder = Path(__file__).parent
        words = (f'"{name}"', f"def {name.replace('-', '_')}(")
        found = [module.name for module in pkgutil.iter_modules(__path__)]
        texts = {module: (folder / f"{module}.py").read_text(encoding="utf-8") for module in found}
        return sorted(found, key=lambda module: (not any(word in texts[module] for word in words), module))

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted(command.name or "" for module in self._modules() for command in _commands(module))

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        for module in self._modules(name):
            for command in _commands(module):
                if command.name == name:
                    return command
        return None


def _commands(module: str) -> Sequence[click.Command]:
    return importlib.import_module(f"{__name__}.{module}").COMMANDS


@click.command(cls=_Commands)
@click.version_option(package_name="eaclutch")
@click.option(
    "--log",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write progress and an error line to this file instead of the terminal (the workflow's rules do).",
)
@click.pass_context
def group(ctx: click.Context, log: Path | None) -> None:
    """Calibrate electroadhesive clutches and diagnose their sim-to-real gap."""
    ctx.meta["log"] = log
    handler: logging.Handler
    if log is None:
        handler = logging.StreamHandler()
    else:
        log.parent.mkdir(parents=True, exist_ok=True)
        handler = logging.FileHandler(log, mode="w", encoding="utf-8")
    handler.setFormatter(logging.Formatter(_LOG_FORMAT, datefmt="%H:%M:%S"))
    logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)


def error_line(error: InputError) -> str:
    """The one line that tells a user what to mend."""
    return f"eaclutch: error: {error}"


def _from_click(error: click.ClickException) -> InputError:
    where = "command line"
    if isinstance(error, click.UsageError) and error.ctx is not None:
        where = error.ctx.command_path
    return InputError(where, error.format_message().rstrip("."), "see --help")


def main(arguments: list[str] | None = None) -> None:
    """Entry point: input errors become one line (in the log if one was named) and exit status 1."""
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        with group.make_context("eaclutch", list(arguments)) as ctx:
            log = ctx.meta.get("log")
            try:
                group.invoke(ctx)
            except click.exceptions.Exit:
                raise
            except click.ClickException as error:
                _stop(_from_click(error), ctx.meta.get("log"))
            except InputError as error:
                _stop(error, ctx.meta.get("log"))
            except Exception:
                log = ctx.meta.get("log")
                if log is None:
                    raise
                logging.exception("unexpected failure")
                sys.exit(2)
    except click.exceptions.Exit as stop:
        sys.exit(stop.exit_code)
    except click.ClickException as error:
        _stop(_from_click(error), None)
    except click.Abort:
        sys.exit(130)


def _stop(error: InputError, log: Path | None) -> None:
    line = error_line(error)
    if log is None:
        print(line, file=sys.stderr)
    else:
        with log.open("a", encoding="utf-8") as stream:
            stream.write(line + "\n")
    sys.exit(1)

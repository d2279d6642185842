"""The command line: one module a room, a sub-command a rule. Modules are found by listing this folder."""

from __future__ import annotations

import errno
import importlib
import logging
import pkgutil
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from eaclutch.records import InputError

# What the machine refuses, and not the program: an error line too.
_MEND = {
    errno.ENOSPC: "make room on the disk and start again",
    errno.EDQUOT: "make room in the quota and start again",
    errno.EROFS: "name a folder that can be written",
    errno.ENOENT: "make it, or name what is there",
    errno.EISDIR: "name a file",
    errno.ENOTDIR: "name a folder",
    errno.EACCES: "give access, or name another folder",
    errno.EPERM: "give access, or name another folder",
}
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
            try:
                group.invoke(ctx)
            except click.exceptions.Exit:
                raise
            except click.ClickException as error:
                _stop(_from_click(error), ctx.meta.get("log"))
            except InputError as error:
                _stop(error, ctx.meta.get("log"))
            except OSError as error:
                remedy = _MEND.get(error.errno or 0)
                if remedy is None:
                    _unexpected(ctx.meta.get("log"))
                else:
                    what = error.strerror or "cannot be used"
                    _stop(InputError(error.filename or "disk", what, remedy), ctx.meta.get("log"))
            except Exception:
                _unexpected(ctx.meta.get("log"))
    except click.exceptions.Exit as stop:
        sys.exit(stop.exit_code)
    except click.ClickException as error:
        _stop(_from_click(error), None)
    except click.Abort:
        sys.exit(130)


def _unexpected(log: Path | None) -> None:
    """Inside an except clause: a failure of ours, with all that helps to find it."""
    if log is None:
        raise
    logging.exception("unexpected failure")
    sys.exit(2)


def _stop(error: InputError, log: Path | None) -> None:
    line = error_line(error)
    if log is not None:
        try:
            with log.open("a", encoding="utf-8") as stream:
                stream.write(line + "\n")
            sys.exit(1)
        except OSError:  # the disk that is full is the log's too
            pass
    print(line, file=sys.stderr)
    sys.exit(1)

"""What a result rests on: hashes of the library's parts, versions, the commit."""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.metadata
import platform
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
# Found by listing their folder: importing one means depending on what lies in it. Effects are named apart,
# so that a new candidate does not rerun what never saw it.
_LISTED = ("eaclutch.rig.observables",)
_EFFECTS = "eaclutch.physics.effects"
_COMMANDS = "eaclutch.cli."  # a command's module serves several rules: each names what it calls


def code_hash(modules: Iterable[str], effects: Iterable[str] = ()) -> str:
    """Hash of the library files that ``modules`` (and the files of ``effects``) come to import, page templates too.

    ``modules``: dotted names below eaclutch, such as ``rig.extract``; unknown ones raise ValueError.
    Returns 16 hexadecimal digits that change when, and only when, one of those files changes.
    """
    pending = [f"eaclutch.{name}" for name in modules]
    pending += [f"{_EFFECTS}.{name}" for name in effects]
    found: dict[str, bytes] = {}
    while pending:
        name = pending.pop()
        if name in found:
            continue
        path = _path(name)
        if path is None:
            raise ValueError(f"there is no module {name}")
        found[name] = path.read_bytes()
        if not name.startswith(_COMMANDS):
            pending += [other for other in _imports(name, path) if other not in found]
        found |= {str(other): other.read_bytes() for other in sorted(path.parent.glob("templates/*"))}
        if name in _LISTED:
            pending += [f"{name}.{other.stem}" for other in path.parent.glob("[!_]*.py")]
            found |= {str(other): other.read_bytes() for other in sorted(path.parent.glob("*.yaml"))}
    digest = hashlib.sha256()
    for name in sorted(found):
        digest.update(f"{name.removeprefix(str(_PACKAGE))}\0{len(found[name])}\0".encode() + found[name])
    return digest.hexdigest()[:16]


def _path(name: str) -> Path | None:
    """The file of a module below eaclutch, or None where the name is no module."""
    base = _PACKAGE.joinpath(*name.split(".")[1:])
    for path in (base.with_suffix(".py"), base / "__init__.py"):
        if path.is_file():
            return path
    return None


def _imports(name: str, path: Path) -> Iterator[str]:
    """Modules of this package that the file imports, wherever in the file, with their parent packages."""
    for module in _imported_names(path, name):
        parts = module.split(".")
        for length in range(2, len(parts) + 1):
            part = ".".join(parts[:length])
            if _path(part) is not None:
                yield part


@functools.cache
def _imported_names(path: Path, name: str) -> tuple[str, ...]:
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    names: list[str] = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            module = ".".join([*above, *([node.module] if node.module else [])])
            names += [module, *(f"{module}.{alias.name}" for alias in node.names)]
    return tuple(item for item in names if item.split(".")[0] == "eaclutch")


def versions() -> dict[str, str]:
    """Versions of Python, of this package and of the libraries that numbers come from."""
    names = ("eaclutch", "numpy", "scipy", "pandas", "numba", "emcee", "arviz", "snakemake", "matplotlib")
    return {"python": platform.python_version()} | {name: importlib.metadata.version(name) for name in names}


def commit() -> str:
    """The checkout's commit, with ``+`` where files differ from it; ``unknown`` outside a checkout."""
    command = ["git", "-C", str(_PACKAGE), "describe", "--always", "--abbrev=40", "--dirty=+", "--exclude=*"]
    try:
        shown = subprocess.run(command, capture_output=True, text=True, check=True, timeout=20)
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return shown.stdout.strip()

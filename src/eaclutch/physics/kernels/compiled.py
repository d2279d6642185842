"""How the solver is compiled.

Cached, in a folder named by the content of this package: numba itself only notices a change in a function's own
file, not in the functions it calls. Division by zero gives inf as in numpy; multiply-adds may be fused; no flag
lets NaN or inf be assumed away, since statuses rest on them.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba import carray, njit, types
from numba.extending import intrinsic

FAST = {"contract", "arcp", "nsz"}


@cache
def cache_folder() -> str:
    """Where compiled code is kept: the user's cache, or a temporary folder where that cannot be written."""
    content = hashlib.sha256()
    for file in sorted([*Path(__file__).parent.glob("*.py"), Path(__file__).parents[1] / "tables.py"]):
        content.update(file.read_bytes())
    name = Path("eaclutch") / f"kernels-{content.hexdigest()[:16]}"
    for base in (os.environ.get("XDG_CACHE_HOME"), Path.home() / ".cache", tempfile.gettempdir()):
        try:
            if base:
                folder = Path(base) / name
                folder.mkdir(parents=True, exist_ok=True)
                if os.access(folder, os.W_OK):
                    return str(folder)
        except OSError:
            continue
    return tempfile.mkdtemp(prefix="eaclutch-")


def _compile(**options: Any) -> Callable[[Callable], Callable]:
    def decorate(function: Callable) -> Callable:
        settings: Any = numba.config
        before, settings.CACHE_DIR = settings.CACHE_DIR, cache_folder()
        try:
            return njit(cache=True, error_model="numpy", fastmath=FAST, **options)(function)
        finally:
            settings.CACHE_DIR = before

    return decorate


compiled = _compile()
inlined = _compile(forceinline=True)
compiled_free = _compile(nogil=True)  # other threads go on while it runs


def threads() -> int:
    """How many threads this process may use (NUMBA_NUM_THREADS; all cores without it)."""
    settings: Any = numba.config
    return int(settings.NUMBA_NUM_THREADS)


@intrinsic
def _pointer(typing_context, address):  # type: ignore[no-untyped-def]
    signature = types.CPointer(types.float64)(types.intp)

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    return signature, generate


@inlined
def unmanaged(array):
    """The same float64 array without reference counts (they cost more than a table look-up where branches keep the
    compiler from dropping them). ``array`` belongs to somebody outside compiled code, who keeps it alive."""
    return carray(_pointer(array.ctypes.data), array.shape)  # type: ignore[call-arg]

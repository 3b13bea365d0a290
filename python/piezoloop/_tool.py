"""The tool ``piezoloop`` as a Python function."""

from __future__ import annotations

import functools
import json
import os
import shutil
import subprocess
import sysconfig
from pathlib import Path
from typing import Any


class PiezoloopError(RuntimeError):
    """The tool refused; the text names file, value, rule and how to fix it."""


class Record(dict):
    """A JSON object whose values can be read as attributes too: ``gap.verdict``."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            known = ", ".join(self) or "nothing"
            raise AttributeError(f"no {name!r} here, but {known}") from None


@functools.cache
def executable() -> Path:
    """The tool: that of ``PIEZOLOOP``, of this environment, or on the search path."""
    given = os.environ.get("PIEZOLOOP")
    if given:
        return Path(given)
    name = "piezoloop.exe" if os.name == "nt" else "piezoloop"
    schemes = [None, f"{os.name}_user"]
    folders = [
        sysconfig.get_path("scripts") if scheme is None else sysconfig.get_path("scripts", scheme)
        for scheme in schemes
    ]
    for folder in folders:
        path = Path(folder) / name
        if path.is_file():
            return path
    found = shutil.which(name)
    if found:
        return Path(found)
    raise PiezoloopError(
        f"the tool {name} is neither in {folders[0]} nor on the search path; install this package, "
        "or set the environment variable PIEZOLOOP to it"
    )


def run(*arguments: str | os.PathLike[str]) -> Any:
    """Runs ``piezoloop --json ARGUMENTS`` and returns its answer, objects as :class:`Record`.

    ``run("list", "rigs")`` gives a list of records. Exit codes 0 (success) and 1 (a check
    failed) are answers; anything else raises.

    Raises:
        PiezoloopError: with the tool's own message.
    """
    command = [executable(), "--json", *map(os.fspath, arguments)]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", stdin=subprocess.DEVNULL)
    if done.returncode not in (0, 1):
        raise PiezoloopError(_message(done.stderr) or f"exit code {done.returncode}")
    try:
        return json.loads(done.stdout, object_hook=Record)
    except json.JSONDecodeError as error:
        raise PiezoloopError(_message(done.stderr) or f"no answer in JSON: {error}") from None


def _message(text: str) -> str:
    """The message in what the tool wrote to standard error."""
    for line in reversed(text.splitlines()):
        try:
            return str(json.loads(line)["error"])
        except (ValueError, KeyError, TypeError):
            continue
    return text.strip()

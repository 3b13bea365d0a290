"""FMUs of the known machines."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

from ._tool import Record, executable, run


def rigs() -> list[Record]:
    """The known machines: ``name`` and ``summary`` of each."""
    return run("list", "rigs")


def path_to_fmu(rig: str, *, fmi: int = 2, folder: str | os.PathLike[str] | None = None) -> str:
    """The FMU of a known machine, packed when it is asked for first.

    An installed wheel carries the shared libraries of Linux (x86-64 and ARM64) and Windows: its
    FMUs run on all of them. Installed from source, they run on this kind of machine.

    Args:
        rig: a name of :func:`rigs`, such as ``"evc"``; or a blueprint file.
        fmi: version of the standard, 2 or 3.
        folder: where the FMU is kept; default: the user's cache, apart for each version of the tool.

    Returns:
        the path as text, which ``fmpy.simulate_fmu`` and others take.

    Raises:
        PiezoloopError: no such rig, or a blueprint that cannot be built.
    """
    is_blueprint = rig.endswith(".toml")
    folder = Path(folder) if folder is not None else _cache()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{Path(rig).stem}-fmi{fmi}.fmu"
    if is_blueprint or not path.is_file():
        libraries = Path(__file__).parent / "libraries"
        further = ["--libraries", libraries] if libraries.is_dir() else []
        run("pack", rig, "--fmi", str(fmi), *further, "--out", path)
    return str(path)


def _cache() -> Path:
    """A folder of this tool's build: a new one packs anew."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or tempfile.gettempdir()
    elif sys.platform == "darwin":
        base = "~/Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    about = executable().stat()
    return Path(base).expanduser() / "piezoloop" / f"{about.st_size:x}-{about.st_mtime_ns:x}"

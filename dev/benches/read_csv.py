"""A large CSV, read by `piezoloop log` (which also looks for doubtful samples) and by polars: time and memory.

    cargo build --release
    python dev/benches/read_csv.py [--megabytes 1000] [--rounds 3] [TOOL]        (needs numpy, polars; Linux)

Each reads in a process of its own, in turn, the file being in the system's cache. Polars takes as many threads as there
are processors, and one. Memory is the most that a process held; the numbers alone take rows x columns x 8 bytes.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np
import polars as pl

ROOT = pathlib.Path(__file__).resolve().parents[2]


def written(path: pathlib.Path, megabytes: float) -> int:
    """Time at 10 kHz and four signals with all their digits; the number of rows."""
    random = np.random.default_rng(1)
    rows = int(megabytes * 1e6 / 79.7)
    columns = {"time": np.round(np.arange(rows) * 1e-4, 4)}
    columns.update({name: random.normal(size=rows) * 10.0 for name in "uyz"})
    columns["w"] = np.round(random.normal(size=rows), 6)
    pl.DataFrame(columns).write_csv(path)
    return rows


def run(command: list, threads: int | None = None) -> tuple[float, float, float]:
    """Seconds on the clock, seconds of processors, MB."""
    environment = dict(os.environ)
    if threads:
        environment["POLARS_MAX_THREADS"] = str(threads)
    begin = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, env=environment)
    _, status, used = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - begin
    if os.waitstatus_to_exitcode(status) not in (0, 1):
        sys.exit(f"{command[0]} ended with {status}")
    return seconds, used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("tool", nargs="?", default=ROOT / "target/release/piezoloop")
    parser.add_argument("--megabytes", type=float, default=1000.0)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "log.csv"
        rows = written(path, given.megabytes)
        print(f"{path.stat().st_size / 1e6:.0f} MB, {rows} rows, 5 columns: {rows * 40 / 1e6:.0f} MB of numbers")
        polars = [sys.executable, "-c", f"import polars; polars.read_csv({str(path)!r})"]
        calls = {
            "piezoloop log": ([given.tool, "log", path], None),
            "polars": (polars, None),
            "polars, one thread": (polars, 1),
        }
        best = {}
        for _ in range(given.rounds):
            for name, (command, threads) in calls.items():
                found = run(command, threads)
                best[name] = min(best.get(name, found), found)
        for name, (seconds, processor, memory) in best.items():
            print(f"{name:20} {seconds:6.2f} s, {processor:6.2f} s of processors, {memory:6.0f} MB")
        ratio = [best["piezoloop log"][0] / best[name][0] for name in ["polars", "polars, one thread"]]
        print(f"piezoloop log takes {ratio[0]:.2f} times the time of polars, {ratio[1]:.2f} of one thread")


main()

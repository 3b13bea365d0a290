"""A sweep on Dask: the runs of ``piezoloop sweep`` over the workers of a cluster.

This module is imported on every worker; a tool that is set up there stays between batches. What a
worker computes are the rows of the tool's own journal, so results have the bits of a local run.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Union

from ._results import Swept
from ._tool import PiezoloopError, _message, executable, run

if TYPE_CHECKING:
    from distributed import Client

PathLike = Union[str, "os.PathLike[str]"]


def sweep(
    plan: PathLike,
    out: PathLike,
    *,
    client: Client | None = None,
    seed: int | None = None,
    threads: int | None = None,
    batch: float = 0.25,
    retries: int = 5,
) -> Swept:
    """Runs the plan of a sweep; the table is the same wherever it runs.

    A sweep that was stopped resumes, here or on a cluster.

    Args:
        plan: the plan, see ``docs/sweep.md``.
        out: the Parquet table to write.
        client: a ``distributed.Client``; without one the runs are done by threads of this machine.
        seed: instead of the plan's.
        threads: of this machine; a cluster has its own.
        batch: work in s that a worker gets at once, at least 0.05; smaller batches cost more in messages.
        retries: how often a failed batch is repeated, for example after a worker was killed.

    Returns:
        the answer of ``piezoloop sweep --json``: ``figures``, ``failed``, ``first_failure``, …

    Raises:
        PiezoloopError: a bad plan, a table of another sweep, workers without this version.
        ValueError: a batch of less than 0.05 s.
    """
    options = [] if seed is None else ["--seed", str(seed)]
    if client is not None:
        if not batch >= 0.05:
            raise ValueError(f"batch = {batch} s: give 0.05 s or more, less is lost to messages")
        _spread(plan, out, options, client, batch, retries)
    if threads is not None:
        options += ["--threads", str(threads)]
    return Swept(run("sweep", plan, *options, "--out", out))


def _spread(
    plan: PathLike, out: PathLike, options: list[str], client: Client, batch: float, retries: int
) -> None:
    """Lets the workers add what is to be done to the journal of the sweep."""
    from distributed import as_completed

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sweep.bundle"
        about = run("sweep", "bundle", plan, *options, "--table", out, "--out", file)
        content = file.read_bytes()
    if not about.todo:
        return
    key = hashlib.sha256(content).hexdigest()
    bundle = client.scatter(content, broadcast=True, hash=False)
    slots = max(1, sum(client.nthreads().values()))
    chunks = _Chunks(about.todo)
    pending = as_completed()

    def send() -> None:
        chunk = chunks.take()
        if chunk is not None:
            pending.add(client.submit(_rows, bundle, key, *chunk, pure=False, retries=retries))

    with _journal(about.journal) as journal:
        # Two batches per thread: one is on its way while the other is worked on.
        for _ in range(2 * slots):
            send()
        for future in pending:
            rows, count, seconds = future.result()
            journal.write(rows)
            journal.flush()
            chunks.learn(count, seconds, batch)
            send()


class _Chunks:
    """Runs that are to be done, in pieces of about the same work."""

    def __init__(self, todo: list[list[int]]) -> None:
        self.todo = [(first, end) for first, end in reversed(todo)]
        self.size = 1

    def take(self) -> tuple[int, int] | None:
        if not self.todo:
            return None
        first, end = self.todo.pop()
        middle = min(end, first + self.size)
        if middle < end:
            self.todo.append((middle, end))
        return first, middle

    def learn(self, count: int, seconds: float, batch: float) -> None:
        """The size of the pieces to come; a piece is at most twice as large as one that is known."""
        wanted = batch * count / max(seconds, 1e-6)
        self.size = max(1, min(round(wanted), 2 * max(count, self.size)))


class _journal:
    """The journal of a sweep, for this process alone while it is open."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __enter__(self) -> BinaryIO:
        self.file = open(self.path, "ab")
        if os.name == "posix":
            import fcntl

            try:
                fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                self.file.close()
                raise PiezoloopError(f"{self.path}: another process runs this sweep") from None
        return self.file

    def __exit__(self, *_: Any) -> None:
        self.file.close()


class _Server:
    """The tool, set up for one sweep: it answers with rows as long as it is asked."""

    def __init__(self, bundle: bytes) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "sweep.bundle"
            file.write_bytes(bundle)
            self.errors = tempfile.TemporaryFile()
            command = [executable(), "sweep", "serve", file]
            pipe = subprocess.PIPE
            self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=self.errors)
            self._line()

    def rows(self, first: int, end: int) -> bytes:
        try:
            self.process.stdin.write(f"{first} {end}\n".encode())
            self.process.stdin.flush()
        except OSError:
            self._failed()
        length = int(self._line())
        rows = self.process.stdout.read(length)
        if len(rows) != length:
            self._failed()
        return rows

    def _line(self) -> bytes:
        line = self.process.stdout.readline()
        if not line.endswith(b"\n"):
            self._failed()
        return line

    def _failed(self) -> None:
        self.process.kill()
        code = self.process.wait()
        self.errors.seek(0)
        said = _message(self.errors.read().decode("utf-8", "replace"))
        raise PiezoloopError(said or f"the tool ended with {code}")


_idle: dict[str, list[_Server]] = {}
_lock = threading.Lock()


def _rows(bundle: bytes, key: str, first: int, end: int) -> tuple[bytes, int, float]:
    """On a worker: the rows of the runs ``first`` to ``end`` − 1, their number, the seconds taken."""
    with _lock:
        # Another sweep's tools are not needed any more.
        for other in [other for other in _idle if other != key]:
            for server in _idle.pop(other):
                server.process.kill()
        servers = _idle.setdefault(key, [])
        server = servers.pop() if servers else None
    if server is None:
        server = _Server(bundle)
    begin = time.perf_counter()
    rows = server.rows(first, end)
    seconds = time.perf_counter() - begin
    with _lock:
        _idle.setdefault(key, []).append(server)
    return rows, end - first, seconds

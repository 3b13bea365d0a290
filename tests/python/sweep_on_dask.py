"""A sweep on Dask: the bytes of the local run; a worker is killed; what is lost to messages.

usage: sweep_on_dask.py PLAN [SCHEDULER]   in the folder of the plan
"""

import filecmp
import os
import signal
import sys
import threading
import time

from distributed import Client, LocalCluster

import piezoloop


def compare(name):
    assert filecmp.cmp("local.parquet", name, shallow=False), f"{name} has other bytes"


def killed(client, cluster):
    """Kills one worker as soon as rows come."""
    processes = [nanny.pid for nanny in cluster.workers.values()]
    journal = "killed.parquet.journal"

    def kill():
        while not os.path.exists(journal) or os.path.getsize(journal) < 4000:
            time.sleep(0.005)
        os.kill(processes[0], signal.SIGKILL)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    piezoloop.sweep(plan, "killed.parquet", client=client, batch=0.05)
    killer.join(1)
    assert not killer.is_alive(), "no worker was killed"
    compare("killed.parquet")
    now = [nanny.pid for nanny in cluster.workers.values()]
    print(f"a worker was killed: the same bytes; processes {processes}, then {now}")


if __name__ == "__main__":
    plan = sys.argv[1]
    local = piezoloop.sweep(plan, "local.parquet")
    if len(sys.argv) > 2:
        with Client(sys.argv[2], timeout=60) as client:
            client.wait_for_workers(2, timeout=60)
            answer = piezoloop.sweep(plan, "spread.parquet", client=client, batch=0.05)
            compare("spread.parquet")
            print(f"{answer.runs} runs on {len(client.nthreads())} workers: the same bytes")
        sys.exit()
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        begin = time.perf_counter()
        piezoloop.sweep(plan, "spread.parquet", client=client, batch=0.05)
        seconds = time.perf_counter() - begin
        compare("spread.parquet")
        more = 100 * (seconds / local.seconds - 1)
        print(f"local {local.seconds:.2f} s, on Dask {seconds:.2f} s with its set-up: {more:.1f} % more")
        killed(client, cluster)
        try:
            piezoloop.sweep("no.toml", "no.parquet", client=client)
            raise AssertionError("an absent plan must be refused")
        except piezoloop.PiezoloopError as error:
            assert "no.toml" in str(error), error
    print("Dask gives the bytes of the local run")

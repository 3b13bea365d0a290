#!/usr/bin/env python3
"""Learned models beside what their users have today: numpy/scipy, scikit-learn, pyswarms.

    cargo build --release -p piezoloop-learned --example peer
    cargo build --release -p piezoloop-identify --example operator
    python3 -m venv env && env/bin/pip install numpy scipy scikit-learn pyswarms
    env/bin/python dev/benches/peers.py [--quick] [--peer target/release/examples/peer] [--operator …]

One thread on both sides. The two sides run in turn on the same data; a figure is the median of the
ratios of the rounds (time of the peer / ours), so that other work on the machine hits both. Answers
are compared before times are.
"""

import argparse
import json
import os
import resource
import statistics
import struct
import subprocess
import sys
import tempfile
import time

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np
import scipy.linalg as sl

ROWS = []


class Peer:
    """Our side: one process per problem, one job per line."""

    def __init__(self, binary, inputs, outputs):
        self.file = tempfile.NamedTemporaryFile(suffix=".f64")
        self.file.write(struct.pack("<dd", *inputs.shape))
        self.file.write(np.ascontiguousarray(inputs, "<f8").tobytes())
        self.file.write(np.asarray(outputs, "<f8").tobytes())
        self.file.flush()
        self.process = subprocess.Popen(
            [binary, self.file.name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, *words):
        self.process.stdin.write(" ".join(str(w) for w in words) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"the job {words[0]} ended with an error")
        return json.loads(line)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def timed(work):
    start = time.perf_counter()
    answer = work()
    return time.perf_counter() - start, answer


def alternate(rounds, theirs, ours):
    """Seconds of both sides, round by round."""
    pairs = []
    for _ in range(rounds):
        seconds, answer = timed(theirs)
        pairs.append((seconds, answer, ours()))
    return pairs


def report(what, wanted, pairs, scale=1.0, note=""):
    ratio = statistics.median(scale * t / o["seconds"] for t, _, o in pairs)
    theirs = statistics.median(scale * t for t, _, _ in pairs)
    mine = statistics.median(o["seconds"] for _, _, o in pairs)
    verdict = "reached" if ratio >= wanted else "not reached"
    ROWS.append({"what": what, "wanted": wanted, "ratio": ratio, "peer_s": theirs, "ours_s": mine})
    print(f"{what:52} {theirs:10.4g} s {mine:10.4g} s {ratio:8.1f}x  (>= {wanted}) {verdict}  {note}",
          flush=True)


def bound(what, limit, seconds):
    verdict = "reached" if seconds <= limit else "not reached"
    ROWS.append({"what": what, "limit_s": limit, "ours_s": seconds})
    print(f"{what:52} {'':12} {seconds:10.4g} s {'':9}  (<= {limit:g} s) {verdict}", flush=True)


# The problems ------------------------------------------------------------------------------------

def narx_problem(n):
    """A Bouc-Wen element in front of a second-order lag: u(t) … u(t−3), y(t−1), y(t−2)."""
    rng, t = np.random.default_rng(0), np.arange(n + 3) * 5e-3
    u = 0.5 + 0.5 * np.sin(np.pi * t - 0.5 * np.pi) * np.cos(0.0217 * np.pi * t)
    y, h, x, v, a = np.zeros(len(u)), 0.0, 0.0, 0.0, 2 * np.pi * 20
    for k in range(1, len(u)):
        du = u[k] - u[k - 1]
        h += 0.6 * du - 3 * abs(du) * h - 0.5 * du * abs(h)
        for _ in range(10):
            v += 5e-4 * (a * a * (u[k] - 0.4 * h - x) - 1.4 * a * v)
            x += 5e-4 * v
        y[k] = x
    y += 1e-3 * rng.standard_normal(len(y))
    inputs = np.column_stack([u[3 - i:len(u) - i] for i in range(4)]
                             + [y[3 - i:len(u) - i] for i in (1, 2)])
    outputs = y[3:]
    return (inputs - inputs.mean(0)) / inputs.std(0), (outputs - outputs.mean()) / outputs.std()


def stop_problem(n=1500, count=55):
    """Three records of stop operators, command and rate, as the nanopositioning paper has them."""
    rng = np.random.default_rng(1)
    blocks, targets = [], []
    for frequency in (3.0, 10.0, 5.0):
        t = np.arange(n // 3) * 2e-3
        u = 2.5 + 2.5 * np.sin(2 * np.pi * frequency * t - np.pi / 2)
        r = np.arange(1, count + 1) * 8.5 / (count + 1)
        z, last = np.clip(u[0], -r, r), u[0]
        for value in u:
            z = np.clip(z + value - last, -r, r)
            blocks.append(np.r_[z, value, (value - last) / 2e-3])
            targets.append(3.5 * value - 0.2 * z[5] - 0.1 * z[20] + 1e-3 * rng.standard_normal())
            last = value
    inputs = np.array(blocks)
    return (inputs - inputs.mean(0)) / (inputs.std(0) + 1e-12), np.array(targets)


def rough_problem(n=2000, d=12):
    rng = np.random.default_rng(2)
    x = rng.standard_normal((n, d))
    return x, np.sin(x[:, 0]) + 0.3 * x[:, 1] + 0.1 * rng.standard_normal(n)


# The peers ---------------------------------------------------------------------------------------

def kernel(a, b, sigma2):
    d = (a * a).sum(1)[:, None] + (b * b).sum(1)[None] - 2 * a @ b.T
    np.maximum(d, 0, out=d)
    d *= -1 / sigma2
    return np.exp(d, out=d)


def lssvm(x, y, gamma, sigma2):
    """scipy's Cholesky of the kernel matrix, two right-hand sides."""
    k = kernel(x, x, sigma2)
    k[np.diag_indices(len(y))] += 1 / gamma
    factor = sl.cho_factor(k, lower=True, overwrite_a=True, check_finite=False)
    both = sl.cho_solve(factor, np.column_stack([y, np.ones(len(y))]), check_finite=False)
    bias = both[:, 0].sum() / both[:, 1].sum()
    return both[:, 0] - bias * both[:, 1], bias


def simulate(x, y, part, centres, alpha, bias, sigma2):
    """Own outputs fed back, over samples that follow each other."""
    z, error = x[part[0]].copy(), 0.0
    for i in part:
        z[:4] = x[i, :4]
        value = np.exp(-((centres - z) ** 2).sum(1) / sigma2) @ alpha + bias
        error += (value - y[i]) ** 2
        z[5], z[4] = z[4], value
    return error


def folds_mse(x, y, gamma, sigma2, folds=5):
    total, n = 0.0, len(y)
    for f in range(folds):
        held = np.arange(f, n, folds)
        kept = np.ones(n, bool)
        kept[held] = False
        alpha, bias = lssvm(x[kept], y[kept], gamma, sigma2)
        total += ((kernel(x[held], x[kept], sigma2) @ alpha + bias - y[held]) ** 2).sum()
    return total / n


def prune_by_inverse(x, y, gamma, sigma2, least):
    """Algorithm 1 with numpy: the inverse of the bordered matrix in every round."""
    kept, rounds = np.arange(len(y)), 0
    while True:
        n = len(kept)
        a = np.ones((n + 1, n + 1))
        a[0, 0] = 0
        a[1:, 1:] = kernel(x[kept], x[kept], sigma2)
        a[np.arange(1, n + 1), np.arange(1, n + 1)] += 1 / gamma
        inverse = np.linalg.inv(a)
        solution = inverse @ np.r_[0.0, y[kept]]
        alpha, bias = solution[1:], solution[0]
        simulate(x, y, np.arange(len(y)), x[kept], alpha, bias, sigma2)
        left = int(0.95 * n)
        if n <= least or left < least:
            return len(kept), rounds
        score = np.abs(alpha * (1 / gamma - 1 / np.diag(inverse)[1:]))
        kept = np.sort(kept[np.argsort(score, kind="stable")[n - left:]])
        rounds += 1


# The benches -------------------------------------------------------------------------------------

def training(binary, rounds):
    previous = None
    for n in (1000, 2000, 4000, 8000):
        x, y = narx_problem(n)
        peer = Peer(binary, x, y)
        if n == 4000:
            for sigma2 in (2, 20):
                pairs = alternate(rounds, lambda: lssvm(x, y, 1e4, sigma2),
                                  lambda: peer.run("train", 1e4, sigma2))
                norms = [abs(np.linalg.norm(t[0]) / o["norm"] - 1) for _, t, o in pairs]
                report(f"train N=4000, sigma^2={sigma2}, scipy Cholesky", 5, pairs,
                       note=f"|alpha| agrees to {max(norms):.0e}, residual {pairs[0][2]['residual']:.0e}")
        seconds = statistics.median(peer.run("train", 1e4, 2)["seconds"] for _ in range(rounds))
        if previous:
            print(f"    N={n}: {seconds:.3f} s, {seconds / previous:.1f} times that of N={n // 2} "
                  "(the kernel matrix alone: 4, Cholesky: 8)")
        previous = seconds
        peer.close()
    x, y = narx_problem(10_000)
    peer = Peer(binary, x, y)
    answer = peer.run("train", 1e4, 2)
    with open(f"/proc/{peer.process.pid}/status") as status:
        peak = next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
    peer.close()
    print(f"{'memory of training N=10 000':52} {peak / 1e6:10.2f} GB  (<= 1.2) {answer['route']}")


def validation(binary, rounds):
    n = 4000
    x, y = narx_problem(n)
    peer = Peer(binary, x, y)
    for sigma2, wanted, what in ((0.1, 3, "full rank"), (2, 3, "rank 322"), (20, 30, "smooth")):
        # One of the ten folds of the peer, times ten.
        held = np.arange(0, n // 10)
        kept = np.arange(n // 10, n)

        def theirs():
            alpha, bias = lssvm(x[kept], y[kept], 1e4, sigma2)
            return simulate(x, y, held, x[kept], alpha, bias, sigma2)

        # The full rank takes minutes: once.
        times = 1 if sigma2 < 1 else rounds
        pairs = alternate(times, theirs, lambda: peer.run("cv", 1e4, sigma2, 10))
        report(f"10-fold validation by simulation, {what}", wanted, pairs, scale=10.0)
    peer.close()


def pruning(binary, rounds, quick):
    n, least = (1500, 200) if quick else (4000, 550)
    x, y = narx_problem(n)
    peer = Peer(binary, x, y)
    pairs = alternate(1 if not quick else rounds, lambda: prune_by_inverse(x, y, 1e4, 2, least),
                      lambda: peer.run("prune", 1e4, 2, least))
    counts = f"{pairs[0][1][0]} and {pairs[0][2]['count']} support vectors left"
    report(f"prune {n} to {least}, numpy inverse each round", 15, pairs, note=counts)
    peer.close()


def searching(binary, rounds, quick):
    x, y = stop_problem()
    peer = Peer(binary, x, y)
    swarm = peer.run("swarm", 5, 30, 3 if quick else 10, 1)
    visited = np.array(swarm["visited"])
    rng = np.random.default_rng(3)
    some = visited[rng.choice(len(visited), 12, replace=False)]
    pairs = []
    for gamma, sigma2 in some:
        try:
            seconds, mse = timed(lambda: folds_mse(x, y, gamma, sigma2))
        except np.linalg.LinAlgError:
            continue
        pairs.append((seconds, mse, peer.run("fitness", 5, gamma, sigma2)))
    report("swarm, one evaluation at places it visits, numpy", 3, pairs)
    each = statistics.mean(t for t, _, _ in pairs)
    found = [peer.run("search", 5) for _ in range(rounds)]
    pairs = [(3000 * each, swarm["mse"], f) for f in found]
    equal = f"mse {found[0]['mse']:.3e} after {found[0]['evaluations']} evaluations, swarm of " \
            f"{swarm['evaluations']} {swarm['mse']:.3e}"
    report("default search against the 30 x 100 swarm of numpy", 50, pairs, note=equal)
    peer.close()


def processes(binary, rounds):
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    x, y = rough_problem()
    y = y - y.mean()
    peer = Peer(binary, x, y)
    gp = GaussianProcessRegressor(
        ConstantKernel(1.0) * RBF(np.full(12, 3.0)) + WhiteKernel(0.01), optimizer=None, alpha=0
    ).fit(x, y)
    theta = gp.kernel_.theta

    def theirs():
        return gp.log_marginal_likelihood(theta, eval_gradient=True, clone_kernel=False)

    pairs = alternate(rounds, theirs, lambda: peer.run("likelihood", 1, 0.1, *[3] * 12))
    value = abs(pairs[0][1][0] / pairs[0][2]["value"] - 1)
    report("GP likelihood and gradient, 2000 x 12, sklearn", 12, pairs,
           note=f"values agree to {value:.0e}")
    answer = peer.run("compressed-gp", 1, 0.1, 8, 250, 3000)
    bound("compressed GP, 250 centres, one step", 1e-6,
          min(peer.run("compressed-gp", 1, 0.1, 8, 250, 3000)["seconds"] for _ in range(rounds)))
    print(f"    greatest difference from the whole process: {answer['worst']:.1e}")
    peer.close()


def steps(binary, rounds):
    rng = np.random.default_rng(4)
    for n, d, limit in ((551, 6, 1e-6), (1500, 57, 1e-5)):
        x = rng.standard_normal((n, d))
        peer = Peer(binary, x, x[:, 0])
        z, alpha, scale = x[0].copy(), np.full(n, 0.1), 1 / d

        def theirs():
            for _ in range(2000):
                np.exp(-((x - z) ** 2).sum(1) * scale) @ alpha

        pairs = [(t / 2000, a, o) for t, a, o in
                 alternate(rounds, theirs, lambda: peer.run("step", 2000))]
        report(f"one step {n} x {d}, numpy", 1, pairs)
        bound(f"one step {n} x {d}, best of {20 * rounds}", limit,
              min(peer.run("step", 500)["seconds"] for _ in range(20 * rounds)))
        peer.close()


class DynamicPlays:
    """y = offset + sum(w*P) + (alpha[s]*u' + beta[s]*u'')*sum(P), all particles at once."""

    def __init__(self, u, period, plays):
        self.u, self.r = u, np.arange(plays) * 0.5 * np.ptp(u) / plays
        self.rate = np.concatenate([[0.0], np.diff(u) / period])
        self.acceleration = np.concatenate([[0.0], np.diff(self.rate) / period])
        falls = self.rate < 0
        self.segment = np.where(falls, np.where(self.acceleration <= 0, 2, 3), np.where(self.acceleration >= 0, 0, 1))

    def run(self, x):
        """Positions of each particle; columns: w, alpha of four segments, beta of four, offset."""
        count = len(self.r)
        w, alpha, beta, offset = x[:, :count], x[:, count:count + 4], x[:, count + 4:count + 8], x[:, -1]
        p = np.zeros_like(w)
        y = np.empty((len(self.u), len(x)))
        for k, (u, s) in enumerate(zip(self.u, self.segment)):
            p = np.maximum(u - self.r, np.minimum(u + self.r, p))
            moving = alpha[:, s] * self.rate[k] + beta[:, s] * self.acceleration[k]
            y[k] = offset + (w * p).sum(1) + moving * p.sum(1)
        return y


def operators(binary, rounds):
    """The dynamic Prandtl-Ishlinskii model of the cutting paper: 10 plays, 4000 samples, swarm of 100 x 100."""
    import logging

    import pyswarms

    period, plays, n = 1e-3, 10, 4000
    t = np.arange(n) * period
    u = 30 * (1 - np.cos(2 * np.pi * 2 * t)) + 6 * (1 - np.cos(2 * np.pi * 11 * t))
    model = DynamicPlays(u, period, plays)
    gain = 0.1 / plays
    fast, hard = np.abs(model.rate).max(), np.abs(model.acceleration).max()
    scale = np.concatenate([np.full(plays, gain), np.full(4, 0.1 * gain / fast), np.full(4, 0.1 * gain / hard), [1.0]])
    rng = np.random.default_rng(3)
    truth = scale * np.concatenate([rng.uniform(0.3, 1.7, plays), rng.uniform(-1, 1, 9)])
    y = model.run(truth[None])[:, 0] + 0.005 * rng.standard_normal(n)
    low = scale * np.concatenate([np.zeros(plays), np.full(9, -2.0)])
    high = scale * np.full(len(scale), 2.0)

    def swarm(iterations):
        optimiser = pyswarms.single.GlobalBestPSO(
            n_particles=100, dimensions=len(scale), options={"c1": 2.0, "c2": 2.0, "w": 0.6}, bounds=(low, high))
        optimiser.rep.logger.setLevel(logging.ERROR)
        cost = lambda x: np.sqrt(((model.run(x) - y[:, None]) ** 2).mean(0))
        return optimiser.optimize(cost, iters=iterations, verbose=False)[0]

    peer = Peer.__new__(Peer)
    peer.file = tempfile.NamedTemporaryFile(suffix=".f64")
    # In a log a position is read before the command of its row acts.
    read = np.concatenate([y[:1], y[:-1]])
    peer.file.write(np.concatenate([[n, period, plays], u, read]).astype("<f8").tobytes())
    peer.file.flush()
    peer.process = subprocess.Popen([binary, peer.file.name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    pairs = alternate(min(rounds, 3), lambda: swarm(100), lambda: peer.run("identify"))
    peer.close()
    theirs, ours = min(t for _, t, _ in pairs), pairs[0][2]["rmse"]
    report("dynamic PI, pyswarms+numpy 100 x 100", 100, pairs,
           note=f"rms error {theirs:.4f} um, ours {ours:.4f} um, noise 0.0050 um")
    if ours > theirs:
        sys.exit("the faster side is less exact")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--peer", default="target/release/examples/peer")
    parser.add_argument("--operator", default="target/release/examples/operator")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--quick", action="store_true", help="smaller pruning and swarm")
    parser.add_argument("--only", nargs="*", help="training validation pruning searching processes operators steps")
    parser.add_argument("--json", help="write the figures here")
    given = parser.parse_args()
    print(f"load {os.getloadavg()[0]:.1f}; numpy {np.__version__}")
    jobs = {
        "steps": lambda: steps(given.peer, given.rounds),
        "training": lambda: training(given.peer, given.rounds),
        "validation": lambda: validation(given.peer, given.rounds),
        "operators": lambda: operators(given.operator, given.rounds),
        "processes": lambda: processes(given.peer, given.rounds),
        "searching": lambda: searching(given.peer, given.rounds, given.quick),
        "pruning": lambda: pruning(given.peer, given.rounds, given.quick),
    }
    for name, job in jobs.items():
        if not given.only or name in given.only:
            job()
    print(f"peak memory of this side {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB")
    if given.json:
        with open(given.json, "w") as file:
            json.dump(ROWS, file, indent=1)


if __name__ == "__main__":
    main()

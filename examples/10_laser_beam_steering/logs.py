"""What lies between the commands: columns of logs, and blueprints put together."""

import csv
import math
import sys

AXES = range(1, 5)
COORDINATES = ["x1", "y1", "x2", "y2"]


def read(file):
    """The columns of a log by name."""
    with open(file) as text:
        rows = list(csv.reader(text))
    names = [name.split(" [")[0] for name in rows[0]]
    return {name: [float(row[k]) for row in rows[1:]] for k, name in enumerate(names)}


def write(file, columns):
    with open(file, "w") as text:
        text.write(",".join(columns) + "\n")
        for row in zip(*columns.values()):
            text.write(",".join(f"{x:.10g}" for x in row) + "\n")


def rms(values):
    return math.sqrt(sum(x * x for x in values) / len(values))


def report(name, run, first):
    """Errors on both detectors: in micrometres, in parts of the detector's motion range and of each path."""
    errors = []
    for k in AXES:
        wanted, found = run[f"reference[{k}]"][first:], run[f"position[{k}]"][first:]
        errors.append((rms([r - p for r, p in zip(wanted, found)]), max(wanted) - min(wanted)))
    for psd, span in ((0, 720), (1, 495)):
        (x, width), (y, height) = errors[2 * psd : 2 * psd + 2]
        both = math.hypot(x, y)
        print(
            f"{name}, PSD {psd + 1}: rms {both:.3f} um = {100 * both / span:.3f} % of its range; of the path's own range "
            f"x {100 * x / width:.2f} %, y {100 * y / height:.2f} %"
        )


def angles():
    """theta = (d - d_min)/(d_max - d_min) of each axis, rising with its command."""
    for k in AXES:
        log = read(f"moved{k}.csv")
        u, d = log[f"command[{k}]"], log[f"position[{k}]"]
        low, high = min(d), max(d)
        if d[u.index(max(u))] < d[u.index(min(u))]:
            low, high = high, low
        theta = [(x - low) / (high - low) for x in d]
        write(f"axis{k}.csv", {"time [s]": log["time"], f"u{k} [V]": u, f"theta{k} [1]": theta})


def join():
    """The four models in one blueprint; and with the optics, whose numbers `calibrate` puts in."""
    texts = [open(f"axis{k}.toml").read() for k in AXES]
    head = texts[0][: texts[0].index("[[axis]]")].replace('name = "axis1"', 'name = "mirrors"')
    whole = head + "\n".join(text[text.index("[[axis]]") :] for text in texts)
    open("axes.toml", "w").write(whole)
    for k, name in zip(AXES, COORDINATES):
        old = f'position = {{ name = "theta{k}", unit = "1" }}'
        assert old in whole
        whole = whole.replace(old, f'motion = {{ unit = "1" }}\nposition = {{ name = "{name}", unit = "um" }}')
    names = ", ".join(f'"theta{k}"' for k in AXES)
    whole += f"""
[[coupling]]
type = "optics-jacobian"
axes = [{names}]
matrix = [[1, 1, 0, 0], [1, 1, 0, 0], [1, 1, 1, 1], [1, 1, 1, 1]]
offset = [0, 0, 0, 0]
"""
    open("optics.toml", "w").write(whole)


def together():
    """Motions of all axes, each at a frequency of its own, for 5 s."""
    time = [0.005 * k for k in range(1001)]
    columns = {"time [s]": time}
    for k, frequency in zip(AXES, (0.7, 0.9, 1.1, 1.3)):
        columns[f"theta{k} [1]"] = [0.5 - 0.35 * math.cos(2 * math.pi * frequency * t) for t in time]
    write("together.csv", columns)


def calibration():
    """Motions that were asked for and coordinates that were measured, in one log."""
    asked, seen = read("together.csv"), read("answers.csv")
    columns = {f"theta{k} [1]": asked[f"theta{k}"] for k in AXES}
    columns |= {f"{name} [um]": seen[f"position[{k}]"] for k, name in zip(AXES, COORDINATES)}
    write("calibration.csv", {"time [s]": seen["time"], **columns})


def bench():
    """The rows of the record in which the reference was played, from the first second on."""
    log = read("run.csv")
    rows = [at for at, row in enumerate(log["bench.row"]) if row >= 0][:801]
    report("on the bench, rate 1", {name: [values[at] for at in rows] for name, values in log.items()}, 200)


def drive():
    """Voltages of all axes at once for 20 s, two frequencies each, with turning points at many levels."""
    time = [0.005 * k for k in range(4001)]
    columns = {"time [s]": time}
    for k, frequency in zip(AXES, (0.7, 0.9, 1.1, 1.3)):
        angles = [2 * math.pi * frequency * t for t in time]
        wave = [75 + 36 * math.sin(a + k) + 24 * math.sin(0.37 * a + 2 * k) for a in angles]
        columns[f"u{k} [V]"] = [min(1, t / 0.5) * u for t, u in zip(time, wave)]
    write("drive.csv", columns)


def compare():
    """What the data sheet's model and the repaired one leave of the last 30 % of the record, which no fit has used."""
    measured = read("driven.csv")
    for name in ("datasheet", "repaired"):
        model = read(f"{name}.csv")
        errors = [
            rms([a - b for a, b in zip(measured[c][2801:], model[c][2801:])])
            for c in (f"position[{k}]" for k in AXES)
        ]
        print(name, "model: rms error", ", ".join(f"{c} {e:.2f} um" for c, e in zip(COORDINATES, errors)))


if __name__ == "__main__":
    globals()[sys.argv[1]]()

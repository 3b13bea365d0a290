"""The hysteresis of axis Y of the rig evc, in fmpy."""

import numpy as np
from fmpy import simulate_fmu

step, stop = 1e-4, 0.2
time = np.arange(round(stop / step) + 1) * step
command = 60 - 60 * np.cos(2 * np.pi * 10 * time)
both = np.stack([command, np.zeros_like(command)], axis=1)  # of both axes


def drive(fmu, columns):
    """Drives an FMU with a table that has these columns; the position of axis Y."""
    inputs = np.empty(len(time), dtype=[("time", float), *columns])
    inputs["time"] = time
    for name, *shape in columns:
        inputs[name] = both if shape[1:] else both[:, int(name[-2]) - 1]
    output = "position" if columns[0][0] == "command" else "position[1]"
    run = simulate_fmu(fmu, stop_time=stop, output_interval=step, input=inputs, output=[output])
    return run[output].reshape(len(time), -1)[:, 0]


position = drive("plant.fmu", [("command[1]", float), ("command[2]", float)])
arrays = drive("plant3.fmu", [("command", float, (2,))])

# The second period; at 60 V on the way up and on the way down.
loop = position[len(time) // 2 :]
up, down, stroke = loop[250], loop[750], np.ptp(loop)
print(f"stroke {stroke:.3f} um; at 60 V {up:.3f} um on the way up, {down:.3f} um on the way down:")
print(f"the loop is {100 * (down - up) / stroke:.1f} % of the stroke wide")
print(f"FMI 2.0 and FMI 3.0 have the same bits: {np.array_equal(position, arrays)}")

# fmpy's own step: the FMU's, doubled until the run has at most 1000 of them.
start = {"command[1]": 60.0}
coarse = simulate_fmu("plant.fmu", stop_time=stop, start_values=start)
fine = simulate_fmu("plant.fmu", stop_time=stop, start_values=start, output_interval=2e-5)
at = np.searchsorted(fine["time"], coarse["time"] - 1e-9)
same = np.array_equal(fine["position[1]"][at], coarse["position[1]"])
print(f"{len(coarse)} rows by fmpy's step, {len(fine)} by 20 us: the same bits at common times: {same}")

"""What each component is run with: parameters, further inputs, and how near the trajectories must be."""

R, W = [0.0, 8.0, 20.0, 35.0], [0.02, 0.03, 0.01, 0.015]
PLAYS = {"r": R, "w": W, "offset": 0.3}
ENVELOPES = {"left_a0": 90.0, "left_a1": 0.012, "left_a2": -0.1, "left_a3": 2.0,
             "right_a0": 95.0, "right_a1": 0.0125, "right_a2": 0.0, "right_a3": 6.0}
BOUC_WEN = {"gain": 0.08, "alpha": 0.3, "beta": 0.04, "gamma": 0.015, "delta": 0.004, "offset": 0.2}
DUHEM = {"slope": 0.08, "initial": 0.055, "decay": 0.04, "offset": 0.2}
DAHL = {"gain": 0.08, "height": 0.6, "length": 20.0, "offset": 0.2}
MU = [0.02 * (1 + (7 * k) % 5) for k in range(36)]
DYNAMIC = {"alpha": [1e-8, 2e-8, 3e-8, 1e-8], "beta": [2e-12, 1e-12, 1e-12, 3e-12]}
LIMITS = {"command_min": -20.0, "command_max": 160.0}
MODE = {"frequency": 300.0, "damping": 0.05}

GAINS = {"kp": 3.0, "ki": 900.0, "kd": 1e-3, "output_min": 3.0, "output_max": 90.0}
SAFE = {"feedforward_gain": 0.9, "rate_max": 2e4, "hold": 0.0, "safe": 12.0}
XU = {"gain": 0.08, "beta": 0.04, "gamma": 0.015}

# The solver's own error; values are tens of V or a few um.
SOLVED = 1e-8
# Blocks without a differential equation: rounding only.
EXACT = 1e-11

# type: (parameters, bound of the greatest difference over the greatest value)
PLANT = {
    "delay": ({"delay": 3.3e-4, "longest": 1e-3}, EXACT),
    "clock-offset": ({"initial": 2.4e-4, "offset": 0.01, "longest": 1e-3}, EXACT),
    "dac-quantisation": ({"resolution": 0.37, "phase": 0.3}, EXACT),
    "amplifier-lag": ({"bandwidth": 400.0, "gain": 1.1}, SOLVED),
    "amplifier-second-order": ({"frequency": 500.0, "damping": 0.6, "gain": 0.9}, SOLVED),
    "amplifier-rc": ({"resistance": 50.0, "capacitance": 5e-6, "current": 0.1}, 2e-7),
    "amplifier-slew": ({"rate": 9e3}, EXACT),
    "amplifier-foldback": ({"continuous": 0.03, "peak": 0.08, "capacitance": 5e-6, "time_constant": 0.01}, EXACT),
    "amplifier-clamp": ({"low": 5.0, "high": 80.0, "softness": 4.0}, EXACT),
    "amplifier-nonlinearity": ({"offset": 0.1, "quadratic": 0.01, "cubic": -0.02, "centre": 50.0, "half_range": 60.0}, EXACT),
    "piezo-charge": ({"capacitance": 5e-6}, EXACT),
    "polarisation-saturation": ({"flattening": 0.05, "centre": 50.0, "half_range": 45.0}, EXACT),
    "actuator-gain": ({"gain": 0.12, "offset": 0.4}, EXACT),
    "actuator-temperature": ({"coefficient": 1e-3, "temperature": 35.0}, EXACT),
    "actuator-ageing": ({"per_decade": 0.03, "age": 0.01}, EXACT),
    "self-heating": ({"loss": 0.05, "capacitance": 5e-6, "resistance": 40.0, "time_constant": 0.02,
                      "coefficient": 0.01, "growth": 0.05, "amplification": 2.0, "averaging": 0.05}, EXACT),
    "thermal-port": ({"growth": 0.05, "loss": 0.05, "capacitance": 5e-6, "coefficient": 0.01, "averaging": 0.05}, EXACT),
    "prandtl-ishlinskii": (PLAYS, EXACT),
    "modified-prandtl-ishlinskii": (PLAYS | {"edge": [-1.0, 1.5, 3.0], "slope": [0.1, -0.2, 0.3]}, EXACT),
    "skewed-play": (PLAYS | {"skew": [0.0, 0.01, -0.005, 0.002], "play_weight": 0.01, "width": 0.2, "width_growth": 0.1, "width_curvature": -0.05, "centre": 50.0, "half_range": 60.0}, EXACT),
    "generalised-play": (PLAYS | ENVELOPES, EXACT),
    "preisach": ({"mu": MU, "low": -5.0, "high": 110.0, "offset": 0.1}, EXACT),
    "bouc-wen": (BOUC_WEN | {"exponent": 1.6}, 1e-9),
    "duhem": (DUHEM, EXACT),
    "dahl": (DAHL, EXACT),
    "rate-dependent-play": (PLAYS | {"gain": 0.02, "rate": 2e-4}, EXACT),
    "lagging-play": (PLAYS | {"gain": 0.02, "bandwidth": 80.0}, EXACT),
    "grpi": (PLAYS | {"a1": 1.02, "a2": -1e-4, "b1": 0.97, "b2": 2e-4}, EXACT),
    "mpi": (PLAYS | {"linear": 0.03, "cubic": 1e-7, "scale": 1.1, "rate": 1e-4}, EXACT),
    "dynamic-prandtl-ishlinskii": (PLAYS | DYNAMIC, EXACT),
    "remanence": ({"remanence": 0.7, "reach": 60.0}, EXACT),
    "kelvin-voigt-creep": ({"share": [0.05, 0.03], "time_constant": [0.003, 0.03]}, SOLVED),
    "logarithmic-creep": ({"gain": 0.02}, SOLVED),
    "fractional-creep": ({"order": 0.1}, SOLVED),
    "load-force": ({"stiffness": 40.0}, EXACT),
    "mode": (MODE | {"gain": 1.2}, SOLVED),
    "mode-pair": (MODE | {"second_frequency": 450.0, "second_damping": 0.03, "share": -0.2}, SOLVED),
    "collocated-mode": (MODE | {"zero_frequency": 220.0, "zero_damping": 0.04}, SOLVED),
    "loaded-mode": (MODE | {"mass": 0.2, "payload": 0.1, "external_stiffness": 1e5}, SOLVED),
    "duffing": (MODE | {"hardening": 0.05, "reference": 4.0}, 3e-6),
    "position-stiffness": (MODE | {"linear": 0.05, "quadratic": -0.03, "centre": 5.0, "half_range": 6.0}, 2e-7),
    "friction": (MODE | {"coulomb": 0.2, "stiction": 0.3, "presliding": 0.05, "stribeck": 300.0}, 3e-4),
    "nonlinear-damping": (MODE | {"coulomb": 0.1, "velocity": 60.0, "growth": 2e-5}, 2e-4),
    "arx": ({"sample_time": 4e-4, "b": [0.276897, -0.540637, 0.263941], "a": [-2.72054, 2.45461, -0.733864]}, EXACT),
    "backlash": ({"width": 0.8, "bridge": 0.2}, EXACT),
    "cutting-force": ({"amplitude": 0.5, "frequency": 131.0, "duty": 0.4, "phase": 0.3}, EXACT),
    "vibration": ({"frequency": [47.0, 133.0], "amplitude": [0.2, 0.1], "phase": [0.3, -1.0]}, EXACT),
    "mechanical-port": ({}, EXACT),
    "thermal-drift": ({"rate": 0.5, "settling": 0.3, "time_constant": 0.02, "expansion": 0.1, "temperature_change": 2.0}, SOLVED),
    "thermal-expansion": ({"expansion": 0.2, "time_constant": 0.01}, SOLVED),
    "disturbance": ({"gain": 0.8}, EXACT),
    "floor-vibration": ({"rms": 0.0}, EXACT),
    "sensor-lag": ({"bandwidth": 700.0}, SOLVED),
    "sensor-second-order": ({"frequency": 800.0}, SOLVED),
    "sensor-butterworth": ({"bandwidth": 600.0, "order": 5}, SOLVED),
    "sensor-scale": ({"gain": 1.02, "offset": 0.1}, EXACT),
    "sensor-polynomial": ({"quadratic": 0.01, "cubic": 0.02, "centre": 5.0, "half_range": 6.0}, EXACT),
    "sensor-quad-cell": ({"radius": 9.0, "centre": 4.0}, EXACT),
    "sensor-noise": ({"rms": 0.0}, EXACT),
    "sensor-drift": ({"per_hour": 0.0}, EXACT),
    "mains-hum": ({"amplitude": [0.3, 0.1], "phase": [0.4, 1.0]}, EXACT),
    "crosstalk": ({"gain": 0.01, "rate_gain": 1e-5}, EXACT),
    "sensor-quantisation": ({"resolution": 0.037, "phase": -0.2}, EXACT),
}

# Couplings of two axes.
COUPLING = {
    "command-coupling": ({"matrix": [[0.0, 0.01], [0.02, 0.0]]}, EXACT),
    "displacement-coupling": ({"matrix": [[0.0, 0.1], [-0.2, 0.0]]}, EXACT),
    "mode-coupling": ({"matrix": [[0.0, 0.01], [0.02, 0.0]], "frequency": [300.0, 250.0], "damping": [0.05, 0.1]}, SOLVED),
    "modal-matrix": ({"direct": [[0.2, 0.0], [0.1, 0.3]], "frequency": [300.0, 150.0], "damping": [0.05, 1.2], "residue": [[0.5, 0.1], [-0.2, 0.6], [0.3, 0.0], [0.1, 0.2]], "rate_residue": [[0.02, 0.0], [0.0, -0.01], [0.0, 0.03], [0.0, 0.0]]}, SOLVED),
    # The FMU holds the amplitude over a step.
    "softening-modes": ({"direct": [[0.2, 0.0], [0.1, 0.3]], "frequency": [300.0, 150.0], "damping": [0.05, 1.2], "frequency_shift": [-0.1, -0.05], "damping_growth": [0.5, 0.2], "residue": [[0.5, 0.1], [-0.2, 0.6], [0.3, 0.0], [0.1, 0.2]], "rate_residue": [[0.02, 0.0], [0.0, -0.01], [0.0, 0.03], [0.0, 0.0]], "amplitude": [3.0, 3.0], "exponent": 2.0}, 2e-4),
    "optics-jacobian": ({"matrix": [[1.0, 0.1], [-0.2, 0.9]], "offset": [0.5, -0.5]}, EXACT),
    "psd-pincushion": ({"distortion": 0.03, "half_size": 12.0}, EXACT),
}

# Controllers: reference in, command out. A word behind the type tells cases apart.
CONTROLLER = {
    "inverse-prandtl-ishlinskii": (PLAYS, EXACT),
    "inverse-modified-prandtl-ishlinskii": (PLAYS | {"edge": [-1.0, 1.5, 3.0], "slope": [0.1, -0.2, 0.3]}, EXACT),
    "inverse-generalised-play": (PLAYS | ENVELOPES, 1e-9),
    "inverse-preisach": ({"mu": MU, "low": -5.0, "high": 110.0, "offset": 0.1}, EXACT),
    "inverse-bouc-wen": (BOUC_WEN | LIMITS, 1e-9),
    "inverse-duhem": (DUHEM | LIMITS, 1e-9),
    "inverse-dahl": (DAHL | LIMITS, 1e-9),
    "inverse-rate-dependent-play": (PLAYS | LIMITS | {"gain": 0.02, "rate": 2e-4}, 1e-9),
    "inverse-grpi": (PLAYS | LIMITS | {"a1": 1.02, "a2": -1e-4, "b1": 0.97, "b2": 2e-4}, 1e-9),
    "inverse-mpi": (PLAYS | LIMITS | {"linear": 0.03, "cubic": 1e-7, "scale": 1.1, "rate": 1e-4}, 1e-9),
    "inverse-dynamic-prandtl-ishlinskii": (PLAYS | LIMITS | DYNAMIC, 1e-9),
    "reference-lead": ({"lag": 5e-4, "inertia": 2e-7, "limit": 1.5}, EXACT),
    "feedforward-gain": ({"gain": 12.0, "offset": 0.3}, EXACT),
    "reference-curve": ({"at": [0.0, 2.0, 5.0, 9.0], "value": [0.2, 1.9, 5.3, 8.8]}, EXACT),
    "command-curve": ({"at": [0.0, 20.0, 50.0, 90.0], "value": [2.0, 19.0, 53.0, 88.0]}, EXACT),
    "pid": (GAINS | {"derivative_filter": 2e-4}, EXACT),
    "pid reversed": (GAINS | {"kp": -3.0, "ki": -900.0}, EXACT),
    "pid safe": (GAINS | SAFE | {"derivative_filter": 2e-4, "tracking_time": 2e-3}, EXACT),
    "incremental-pid": (GAINS, EXACT),
    "incremental-pid safe": (GAINS | SAFE, EXACT),
    "bouc-wen-feedforward": (XU | {"alpha": 0.3, "lag": 5e-4, "inertia": 2e-7, "limit": 0.4}, EXACT),
    "bouc-wen-feedforward backwards": (XU | {"alpha": 0.9}, 1e-9),
    "notch": ({"frequency": 480.0, "damping": 0.4, "depth": 0.1}, EXACT),
    "reference-filter": ({"frequency": 200.0, "damping": 0.8}, EXACT),
    "reference-filter critical": ({"frequency": 200.0}, EXACT),
    "reference-filter slow": ({"frequency": 200.0, "damping": 1.3}, EXACT),
    "reference-filter wide": ({"frequency": 5000.0, "damping": 1.3}, EXACT),
    "reference-preview": ({"preview": 3.3e-4, "longest": 1e-3}, EXACT),
    "inverse-kelvin-voigt-creep": ({"share": [0.05, 0.03], "time_constant": [0.003, 0.03]}, EXACT),
    "disturbance-observer": ({"bandwidth": 90.0, "lag": 1e-3, "delay": 2.4e-4, "longest": 1e-3, "limit": 1.3}, EXACT),
    "repetitive": ({"cycle": 5e-3, "half": 4, "gain": 3.0, "lead": 3e-4, "keep": 0.95, "limit": 9.0}, EXACT),
    "integral-resonant-control": ({"gain": 6.0, "frequency": 400.0, "setpoint_weight": 0.3}, EXACT),
    "positive-position-feedback": ({"gain": 6.0, "frequency": 700.0, "damping": 0.4}, EXACT),
    "non-minimum-phase-damping": ({"gain": 6.0, "frequency": 500.0, "setpoint_weight": 0.0}, EXACT),
    "jacobian-coordinator": ({"matrix": [[0.05, 0.9], [1.1, -0.2]], "offset": [0.5, -0.3]}, EXACT),
}


def add_declared(rows):
    """A case for each component that has none above: the example that it declares, without an error beyond rounding."""
    for kind, row in rows.items():
        if "example" not in row or kind in PLANT or kind in COUPLING or kind in CONTROLLER:
            continue
        lists = {quantity["name"] for quantity in row["parameters"] if quantity["length"]}
        names = {quantity["name"] for quantity in row["parameters"]}
        given = {name: values if name in lists else values[0] for name, values in row["example"].items()}
        limits = {name: value for name, value in LIMITS.items() if name in names}
        (CONTROLLER if row["stage"] == "control" else PLANT)[kind] = (limits | given, EXACT)

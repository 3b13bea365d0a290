"""plant2.fmu (FMI 2.0) and plant3.fmu (FMI 3.0) through fmpy's low-level classes: a whole life with
saved, serialised and restored states, a reset and a second life. Both versions, the same bits."""

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

period, steps = 20e-6, 600


def command(k):
    return [3.0 + 2.0 * np.sin(0.02 * k), 4.0 + 3.0 * np.cos(0.05 * k)]


class Two:
    def __init__(self):
        d = read_model_description("plant2.fmu")
        vr = {v.name: v.valueReference for v in d.modelVariables}
        self.fmu = FMU2Slave(guid=d.guid, unzipDirectory=extract("plant2.fmu"), instanceName="two",
                             modelIdentifier=d.coSimulation.modelIdentifier)
        self.inputs = [vr["command[1]"], vr["command[2]"]]
        self.outputs = [vr["position[1]"], vr["position[2]"]]
        self.fmu.instantiate(loggingOn=True)

    def begin(self, start):
        self.fmu.setupExperiment(startTime=start)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, start, k):
        self.fmu.setReal(self.inputs, command(k))
        self.fmu.doStep(start + k * period, period)

    def read(self):
        return self.fmu.getReal(self.outputs)

    def save(self):
        return self.fmu.getFMUstate()

    def restore(self, state):
        self.fmu.setFMUstate(state)

    def through_bytes(self, state):
        data = self.fmu.serializeFMUstate(state)
        self.fmu.freeFMUstate(state)
        return self.fmu.deSerializeFMUstate(data)

    def free(self, state):
        self.fmu.freeFMUstate(state)


class Three:
    def __init__(self):
        d = read_model_description("plant3.fmu")
        # fmpy lists aliases as variables; each reference counts once.
        own = {v.valueReference: v for v in reversed(d.modelVariables)}
        of = lambda causality: [own[r] for r in sorted(own) if own[r].causality == causality]
        count = lambda all: sum(int(np.prod(v.shape)) if v.shape else 1 for v in all)
        self.fmu = FMU3Slave(guid=d.guid, unzipDirectory=extract("plant3.fmu"),
                             instanceName="three",
                             modelIdentifier=d.coSimulation.modelIdentifier)
        outputs = of("output")
        self.inputs = [v.valueReference for v in of("input")]
        self.outputs, self.values = [v.valueReference for v in outputs], count(outputs)
        self.fmu.instantiate(loggingOn=True)

    def begin(self, start):
        self.fmu.enterInitializationMode(startTime=start)
        self.fmu.exitInitializationMode()

    def step(self, start, k):
        self.fmu.setFloat64(self.inputs, command(k))
        answer = self.fmu.doStep(start + k * period, period)
        assert answer == (False, False, False, start + k * period + period), answer

    def read(self):
        return self.fmu.getFloat64(self.outputs, nValues=self.values)

    def save(self):
        return self.fmu.getFMUState()

    def restore(self, state):
        self.fmu.setFMUState(state)

    def through_bytes(self, state):
        data = self.fmu.serializeFMUState(state)
        self.fmu.freeFMUState(state)
        return self.fmu.deserializeFMUState(data)

    def free(self, state):
        self.fmu.freeFMUState(state)


def life(master, start):
    master.begin(start)
    rows = []
    for k in range(steps):
        if k == steps // 2:
            state = master.through_bytes(master.save())
            at = master.read()
        master.step(start, k)
        rows.append(master.read())
    master.restore(state)
    assert master.read() == at
    for k in range(steps // 2, steps):
        master.step(start, k)
        assert master.read() == rows[k], k
    master.free(state)
    master.fmu.terminate()
    assert master.read() == rows[-1]
    master.fmu.reset()
    return rows


two, three = Two(), Three()
first = life(two, 0.0)
assert life(two, 2.5) == first == life(three, 0.0) == life(three, 2.5)
assert np.ptp(np.array(first)[:, 0]) > 0.01
two.fmu.freeInstance()
three.fmu.freeInstance()
print(f"fmpy: {steps} steps, twice in FMI 2.0 and twice in FMI 3.0, the same bits")

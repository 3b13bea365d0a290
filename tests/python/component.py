"""FMUs given by name, each with a library and a WebAssembly component: wasmtime runs the component as fmpy runs the
library, and every output is the same to the bit, before and behind a saved state; a state of one is read by the other.
The component gets nothing but the callbacks of FMI-LS-WASM, a bound of memory and a budget of instructions."""
import re
import struct
import sys
import zipfile

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave
from wasmtime import Config, Engine, Store
from wasmtime.component import Component, Linker

config = Config()
config.consume_fuel = True
# Compiled fast: each component is used for 1500 steps.
config.cranelift_opt_level = "none"
engine = Engine(config)
STEPS = 1500


class Wasm:
    """The component of an FMU in a store of its own."""

    def __init__(self, path, token, name="wasm", memory=64 << 20, fuel=1 << 62):
        archive = zipfile.ZipFile(path)
        wasm, = (n for n in archive.namelist() if n.startswith("binaries/wasm32-wasip2/"))
        component = Component(engine, archive.read(wasm))
        self.store, self.messages = Store(engine), []
        self.store.set_limits(memory_size=memory)
        self.store.set_fuel(fuel)
        linker = Linker(engine)
        with linker.root() as root, root.add_instance("fmi:fmi3/callbacks@3.0.0") as callbacks:
            callbacks.add_func("log-message", lambda store, *message: self.messages.append(message))
            for other in ("clock-update", "lock-preemption", "unlock-preemption"):
                callbacks.add_func(other, lambda store: None)
        self.instance = linker.instantiate(self.store, component)
        self.interface = self.instance.get_export_index(self.store, "fmi:fmi3/co-simulation@3.0.0")
        self.resource = None
        make = self.function("[static]co-simulation-instance.instantiate-co-simulation")
        self.resource = make(name, token, "", False, True, False, False, [])

    def function(self, name):
        index = self.instance.get_export_index(self.store, name, self.interface)
        function = self.instance.get_func(self.store, index)

        def call(*arguments):
            answer = function(self.store, *arguments)
            function.post_return(self.store)
            return answer
        return call

    def __getattr__(self, name):
        method = self.function("[method]co-simulation-instance." + name.replace("_", "-"))
        bound = lambda *arguments: method(self.resource, *arguments)
        setattr(self, name, bound)
        return bound


def bits(values):
    return struct.pack(f"{len(values)}d", *values)


def compare(path):
    description = read_model_description(path)
    own = {v.valueReference: v for v in reversed(description.modelVariables)}
    of = lambda causality: [own[r] for r in sorted(own) if own[r].causality == causality and own[r].type == "Float64"]
    count = lambda all: sum(int(np.prod(v.shape)) if v.shape else 1 for v in all)
    inputs, outputs = of("input"), of("output")
    native = FMU3Slave(guid=description.instantiationToken, unzipDirectory=extract(path), instanceName="native",
                       modelIdentifier=description.coSimulation.modelIdentifier)
    native.instantiate()
    wasm = Wasm(path, description.instantiationToken)
    assert wasm.resource is not None, wasm.messages
    native.enterInitializationMode()
    native.exitInitializationMode()
    assert wasm.enter_initialization_mode(None, 0.0, None) == "ok" and wasm.exit_initialization_mode() == "ok"
    where_in, where_out = [v.valueReference for v in inputs], [v.valueReference for v in outputs]
    period = float(description.coSimulation.fixedInternalStepSize)
    low = [float(v.min if v.min is not None else -1) for v in inputs for _ in range(count([v]))]
    high = [float(v.max if v.max is not None else 1) for v in inputs for _ in range(count([v]))]
    random = np.random.default_rng(34)
    print(f"{path}: seed 34, {len(low)} inputs, {count(outputs)} outputs")

    def run(first, courses):
        rows = []
        for k, course in enumerate(courses):
            native.setFloat64(where_in, list(course))
            native.doStep((first + k) * period, period)
            assert wasm.set_float64(where_in, list(course)) == "ok"
            done = wasm.do_step((first + k) * period, period, True)
            assert not isinstance(done, str), (k, done, wasm.messages)
            wanted, got = native.getFloat64(where_out, count(outputs)), wasm.get_float64(where_out)
            assert bits(list(wanted)) == bits(list(got)), (path, first + k, list(wanted), list(got))
            rows.append(bits(list(got)))
        return rows

    held = random.uniform(low, high, (STEPS // 25, len(low))).repeat(25, axis=0)
    run(0, held[:STEPS // 2])
    state, saved = native.getFMUState(), wasm.get_fmu_state()
    assert native.serializeFMUState(state) == bytes(saved), "the states"
    behind = run(STEPS // 2, held[STEPS // 2:])
    # Back, each with the other's state.
    native.setFMUState(native.deserializeFMUState(bytes(saved)))
    assert wasm.set_fmu_state(bytes(saved)) == "ok"
    assert run(STEPS // 2, held[STEPS // 2:]) == behind
    # What one cannot do is said.
    assert wasm.get_float64([10 ** 6]) == "error" and "1000000" in wasm.messages[-1][3], wasm.messages[-1]
    assert wasm.reset() == "ok" and wasm.terminate() == "error"
    native.terminate()
    native.freeInstance()


for path in sys.argv[1:]:
    compare(path)

# Bounds that the importer sets hold, and another FMU's token is refused with a reason.
path = sys.argv[1]
token = read_model_description(path).instantiationToken
refused = Wasm(path, "another")
assert refused.resource is None and token in refused.messages[-1][3], refused.messages
for bounds in ({"memory": 1 << 20}, {"fuel": 1000}):
    try:
        Wasm(path, token, **bounds)
    except Exception as error:
        print(f"{bounds}: {str(error).splitlines()[-1]}")
    else:
        raise AssertionError(f"{bounds} did not stop it")
print(f"{len(sys.argv) - 1} FMUs, {STEPS} steps: the same bits")

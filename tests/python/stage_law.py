import math

from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class StageLaw(Fmi2Slave):
    """A gain and a first-order lag."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u = self.y = 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def exit_initialization_mode(self):
        self.y = 0.1 * self.u

    def do_step(self, time, step):
        self.y -= math.expm1(-2 * math.pi * 200 * step) * (0.1 * self.u - self.y)
        return True

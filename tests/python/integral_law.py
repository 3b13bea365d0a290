from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class IntegralLaw(Fmi2Slave):
    """Integral control of one axis."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.reference = self.measured = self.command = 0.0
        for name in ("reference", "measured"):
            self.register_variable(Real(
                f"{name}[1]", causality=Fmi2Causality.input,
                getter=lambda name=name: getattr(self, name),
                setter=lambda value, name=name: setattr(self, name, value),
            ))
        self.register_variable(Real(
            "command[1]", causality=Fmi2Causality.output, getter=lambda: self.command))

    def do_step(self, time, step):
        self.command += 400.0 * step * (self.reference - self.measured)
        return True

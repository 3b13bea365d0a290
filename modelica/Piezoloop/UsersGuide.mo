within Piezoloop;
class UsersGuide "User's guide"
  extends Icons.Information;

  class Overview "What the library is for"
    extends Icons.Information;
    annotation(Documentation(info="<html>
<p>Components of piezo-actuated machines: amplifier, stack, hysteresis, creep, mechanics, sensor, surroundings, and the controllers that
are designed for them. Each block is a component of the tool Piezoloop, with the same names, bounds and start values: the numbers of an
identified blueprint can be copied, and the FMU of the blueprint moves as the block does.</p>
<table border=\"1\"><tr><th>package</th><th>what is there</th></tr>
<tr><td>Examples</td><td>one model per block; electromechanical chains with energy balance; rigs</td></tr>
<tr><td>Electrical</td><td>amplifier blocks; <code>Electrical.Analog</code>: stack and amplifier with pins</td></tr>
<tr><td>Hysteresis</td><td>operators of hysteresis as blocks</td></tr>
<tr><td>Mechanics</td><td>modes, friction, backlash, load as blocks; <code>Mechanics.Translational</code>: the same with flanges</td></tr>
<tr><td>Sensors</td><td>lag, noise, curve and converter of the reading</td></tr>
<tr><td>Inverse, Controllers</td><td>inverse feedforward; PID forms, filters, observer, Jacobian coordinator</td></tr>
<tr><td>Blocks</td><td>timing, actuator, creep, coupling, surroundings</td></tr>
<tr><td>Rigs, Records</td><td>known machines and measured specimens</td></tr></table>
</html>"));
  end Overview;

  class Units "Units at connectors and of parameters"
    extends Icons.Information;
    annotation(Documentation(info="<html>
<p>Every connector is in SI units: positions in m (shown in um), forces in N, temperatures in K, voltages in V, currents in A. A position
of 5 um that is connected to an input in m arrives as 5e-6 m.</p>
<p>Parameters of blocks have the unit of the blueprint, which is written at each of them (um/V, Hz, um): numbers can be copied. Parameters of
the components with pins and flanges are in SI.</p>
</html>"));
  end Units;

  class Conventions "Sampling, start, names"
    extends Icons.Information;
    annotation(Documentation(info="<html>
<ul>
<li>Blocks with memory of the command (hysteresis, delay, backlash, control laws) run once per <code>step</code>, as the FMU does. All others
are differential or algebraic equations and start at rest under their first input.</li>
<li>A block is its component's type in capitals: <code>amplifier-lag</code> is <code>AmplifierLag</code>. A name that Modelica reserves ends in an
underscore: <code>delay_</code>, <code>initial_</code>.</li>
<li>Random numbers are inputs: connect any source of independent normal numbers.</li>
<li>Connectors have the variables of the Modelica Standard Library's, so flanges, pins and signals of both libraries can be connected; the
library itself needs no other.</li>
</ul>
</html>"));
  end Conventions;

  class Contact "Licence and contact"
    extends Icons.Information;
    annotation(Documentation(info="<html><p>MIT or Apache-2.0. Version 0.1.0. Part of Piezoloop: https://github.com/piezoloop/piezoloop</p></html>"));
  end Contact;
  annotation(DocumentationClass=true, Documentation(info="<html><p>How the library is organised and how it is used.</p></html>"));
end UsersGuide;

within Piezoloop.Blocks;
package Actuator "The actuator apart from its memory"
  block PolarisationSaturation "Flattening of the strain towards the ends of the voltage range"
    extends Interfaces.CommandFilter;
    parameter Real flattening(unit="1", min = 0, max = 0.3) "Loss at the ends as a part of half the range";
    parameter Real centre(unit="V") "Middle of the range";
    parameter Real half_range(unit="V", min = 0) "Half of the range";
  protected
    Real xi(unit="1") "Place in the range, -1 to 1";
    Real inside(unit="1") "The same, limited to the range";
  equation
    xi = (u - centre)/half_range;
    inside = max(-1, min(1, xi));
    y = centre + half_range*(inside - flattening*inside^3 + (1 - 3*flattening)*(xi - inside));
    annotation(Documentation(info="<html><p>Component <code>polarisation-saturation</code>:</p><p><code>v = centre + half_range*(xi - flattening*xi^3); xi = (u - centre)/half_range, straight beyond 1</code></p></html>"));
  end PolarisationSaturation;

  block ActuatorGain "Linear actuator: position proportional to command"
    extends Interfaces.Actuator;
    parameter Real gain(unit="um/V") "Position per command";
    parameter Real offset(unit="um") = 0 "Position at zero command";
  equation
    y_um = gain*u + offset;
    annotation(Documentation(info="<html><p>Component <code>actuator-gain</code>:</p><p><code>y = gain*u + offset</code></p></html>"));
  end ActuatorGain;

  block ActuatorTemperature "Gain of the actuator over its temperature"
    extends Interfaces.PositionFilter;
    parameter Real coefficient(unit="1/K") "Relative change of the gain per kelvin";
    parameter Real temperature(unit="degC", min = -273.15) = 20 "Temperature of the actuator";
    parameter Real reference(unit="degC", min = -273.15) = 20 "Temperature at which the gain is 1";
  equation
    y_um = u_um*(1 + coefficient*(temperature - reference));
    annotation(Documentation(info="<html><p>Component <code>actuator-temperature</code>:</p><p><code>y = x*(1 + coefficient*(temperature - reference))</code></p></html>"));
  end ActuatorTemperature;

  block ActuatorAgeing "Ageing of the actuator: its gain falls with the logarithm of time"
    extends Interfaces.PositionFilter;
    parameter Real per_decade(unit="1") "Relative loss of the gain per decade of time";
    parameter Real age(unit="s", min = 0) = 86400 "Time since poling at the start of the run";
  equation
    y_um = u_um*max(0, 1 - per_decade*log10(1 + time/age));
    annotation(Documentation(info="<html><p>Component <code>actuator-ageing</code>:</p><p><code>y = x*(1 - per_decade*lg(1 + t/age))</code></p></html>"));
  end ActuatorAgeing;

  block SelfHeating "Warming of the actuator by its own losses: gain and length"
    extends Interfaces.PositionFilter;
    parameter Real loss(unit="1", min = 0) "Loss tangent";
    parameter Real capacitance(unit="F", min = 0) "Capacitance";
    parameter Real resistance(unit="K/W", min = 0) "Thermal resistance to the surroundings";
    parameter Real time_constant(unit="s", min = 0) "Thermal time constant";
    parameter Real coefficient(unit="1/K") = 0 "Relative change of the gain per kelvin";
    parameter Real growth(unit="um/K") = 0 "Change of the position per kelvin";
    parameter Real amplification(unit="1") = 1 "Voltage per command";
    parameter Real averaging(unit="s", min = 0) = 1 "Time over which the mean voltage is taken";
    Interfaces.CommandInput command "Command of the axis";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real last(start = 0, fixed = true, unit="V") "Voltage at the last sample";
    discrete Real mean(start = 0, fixed = true, unit="V") "Mean voltage";
    discrete Real middle(start = 0, fixed = true, unit="V") "Alternating voltage in the middle of the step";
    discrete Real P(start = 0, fixed = true, unit="W") "Loss";
    discrete Real T(start = 0, fixed = true, unit="K") "Warming";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      last = amplification*command;
      middle = if pre(on) then 0.5*(last + pre(last)) - pre(mean) else 0;
      P = if pre(on) then Constants.pi/2*loss*capacitance*abs(middle*(last - pre(last)))/step else 0;
      T = pre(T) + (1 - exp(-step/time_constant))*(resistance*P - pre(T));
      mean = if pre(on) then pre(mean) + (1 - exp(-step/averaging))*(last - pre(mean)) else last;
    end when;
    y_um = u_um*(1 + coefficient*T) + growth*T;
    annotation(Documentation(info="<html><p>Component <code>self-heating</code>:</p><p><code>time_constant*T' = resistance*P - T; P = pi/2*loss*capacitance*|(v - mean(v))*v'|; y = x*(1 + coefficient*T) + growth*T</code></p></html>"));
  end SelfHeating;

  block Remanence "What an unknown past leaves in the position until the command has wiped it out"
    extends Interfaces.PositionFilter;
    parameter Real remanence(unit="um") "Difference at the start";
    parameter Real reach(unit="V", min = 0) "Excursion of the command that wipes it out";
    Interfaces.CommandInput command "Command of the axis";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real first(start = 0, fixed = true, unit="V") "Command at the start";
    discrete Real reached(start = 0, fixed = true, unit="V") "Greatest excursion so far";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      first = if pre(on) then pre(first) else command;
      reached = max(pre(reached), abs(command - first));
    end when;
    y_um = u_um + remanence*max(0, 1 - reached/reach);
    annotation(Documentation(info="<html><p>Component <code>remanence</code>:</p><p><code>y = x + remanence*max(0, 1 - w/reach); w = max |u(s) - u(0)|, s &lt;= t</code></p></html>"));
  end Remanence;
end Actuator;

within Piezoloop.Blocks;
package Actuator "The actuator apart from its memory"
  extends Icons.Package;
  block PolarisationSaturation "Saturation of the strain towards both ends of the voltage range"
    extends Interfaces.CommandFilter;
    parameter Real flattening(unit="1", min = 0, max = 0.3) "Loss at the ends, relative to half the range";
    parameter Real centre(unit="V") "Middle of the range";
    parameter Real half_range(unit="V", min = 0) "Half of the range";
  protected
    Real xi(unit="1") "Place in the range, -1 to 1";
    Real inside(unit="1") "The same, limited to the range";
  equation
    xi = (u - centre)/half_range;
    inside = max(-1, min(1, xi));
    y = centre + half_range*(inside - flattening*inside^3 + (1 - 3*flattening)*(xi - inside));
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-60},{-60,-52},{-40,-38},{-20,-20},{0,0},{20,20},{40,38},{60,52},{80,60}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>polarisation-saturation</code>. Saturation of the strain towards both ends of the voltage range.</p><p><code>v = centre + half_range*(xi - flattening*xi^3); xi = (u - centre)/half_range, straight beyond 1</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>flattening</td><td>1</td><td>required</td><td>0</td><td>0.3</td><td>Loss at the ends, relative to half the range</td></tr><tr><td>centre</td><td>{command}</td><td>required</td><td></td><td></td><td>Middle of the range</td></tr><tr><td>half_range</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Half of the range</td></tr></table><p>Source: IEEE Std 176-1987, IEEE Standard on Piezoelectricity (nonlinear limits).</p><p>Effect: <code>polarisation_saturation</code>.</p><p>In the residual: large signals only; odd harmonic, at the top and the bottom of the stroke.</p><p>Looks like: <code>amplifier_saturation</code>, <code>sensor_nonlinearity</code>.</p><p>Distinguished by: record the amplifier's monitor voltage; shift the working range.</p></html>"));
  end PolarisationSaturation;

  block ActuatorGain "Linear actuator: position proportional to command"
    extends Interfaces.Actuator;
    parameter Real gain(unit="um/V") "Position per command";
    parameter Real offset(unit="um") = 0 "Position at zero command";
  equation
    y_um = gain*u + offset;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>actuator-gain</code>. Linear actuator: position proportional to command.</p><p><code>y = gain*u + offset</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Position per command</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command</td></tr></table><p>Source: linear piezoelectric effect, IEEE Std 176-1987.</p><p>Compensated in front of the machine by feedforward-gain (closed form).</p><p>Effect: <code>actuator_gain</code>.</p><p>In the residual: proportional to the signal at all frequencies below the first resonance.</p><p>Looks like: <code>resonance_shift</code>, <code>sensor_nonlinearity</code>.</p><p>Distinguished by: a second sensor or the monitor voltage; log the temperature.</p></html>"));
  end ActuatorGain;

  block ActuatorTemperature "Temperature dependence of the actuator's gain"
    extends Interfaces.PositionFilter;
    parameter Real coefficient(unit="1/K") "Relative change of the gain per kelvin";
    parameter Real temperature(unit="degC", min = -273.15) = 20 "Temperature of the actuator";
    parameter Real reference(unit="degC", min = -273.15) = 20 "Temperature at which the gain is 1";
  equation
    y_um = u_um*(1 + coefficient*(temperature - reference));
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>actuator-temperature</code>. Temperature dependence of the actuator's gain.</p><p><code>y = x*(1 + coefficient*(temperature - reference))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>coefficient</td><td>1/K</td><td>required</td><td></td><td></td><td>Relative change of the gain per kelvin</td></tr><tr><td>temperature</td><td>degC</td><td>20</td><td>-273.15</td><td></td><td>Temperature of the actuator</td></tr><tr><td>reference</td><td>degC</td><td>20</td><td>-273.15</td><td></td><td>Temperature at which the gain is 1</td></tr></table><p>Source: makers' tables of multilayer actuators.</p><p>Effect: <code>actuator_gain</code>.</p><p>In the residual: proportional to the signal at all frequencies below the first resonance.</p><p>Looks like: <code>resonance_shift</code>, <code>sensor_nonlinearity</code>.</p><p>Distinguished by: a second sensor or the monitor voltage; log the temperature.</p></html>"));
  end ActuatorTemperature;

  block ActuatorAgeing "Ageing of the actuator: its gain falls with the logarithm of time"
    extends Interfaces.PositionFilter;
    parameter Real per_decade(unit="1") "Relative loss of the gain per decade of time";
    parameter Real age(unit="s", min = 0) = 86400 "Time since poling at the start of the run";
  equation
    y_um = u_um*max(0, 1 - per_decade*log10(1 + time/age));
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,70},{-55,28},{-21,-9},{24,-41},{80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>actuator-ageing</code>. Ageing of the actuator: its gain falls with the logarithm of time.</p><p><code>y = x*(1 - per_decade*lg(1 + t/age))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>per_decade</td><td>1</td><td>required</td><td></td><td></td><td>Relative loss of the gain per decade of time</td></tr><tr><td>age</td><td>s</td><td>86400</td><td>0</td><td></td><td>Time since poling at the start of the run</td></tr></table><p>Source: B. Jaffe, W. R. Cook, H. Jaffe, Piezoelectric Ceramics, Academic Press 1971, ch. 2.</p><p>Effect: <code>actuator_gain</code>.</p><p>In the residual: proportional to the signal at all frequencies below the first resonance.</p><p>Looks like: <code>resonance_shift</code>, <code>sensor_nonlinearity</code>.</p><p>Distinguished by: a second sensor or the monitor voltage; log the temperature.</p></html>"));
  end ActuatorAgeing;

  block SelfHeating "Self-heating of the actuator by its losses, which changes gain and length"
    extends Interfaces.PositionFilter;
    parameter Real loss(unit="1", min = 0) "Loss tangent";
    parameter Real capacitance(unit="F", min = 0) "Capacitance";
    parameter Real resistance(unit="K/W", min = 0) "Thermal resistance to the surroundings";
    parameter Real time_constant(unit="s", min = 0) "Thermal time constant";
    parameter Real coefficient(unit="1/K") = 0 "Relative change of the gain per kelvin";
    parameter Real growth(unit="um/K") = 0 "Change of the position per kelvin";
    parameter Real amplification(unit="1") = 1 "Voltage per command";
    parameter Real averaging(unit="s", min = 0) = 1 "Time over which the mean voltage is taken";
    Interfaces.CommandInput command "Command of the axis" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,70},{80,61}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>self-heating</code>. Self-heating of the actuator by its losses, which changes gain and length.</p><p><code>time_constant*T' = resistance*P - T; P = pi/2*loss*capacitance*|(v - mean(v))*v'|; y = x*(1 + coefficient*T) + growth*T</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>loss</td><td>1</td><td>required</td><td>0</td><td></td><td>Loss tangent</td></tr><tr><td>capacitance</td><td>F</td><td>required</td><td>0</td><td></td><td>Capacitance</td></tr><tr><td>resistance</td><td>K/W</td><td>required</td><td>0</td><td></td><td>Thermal resistance to the surroundings</td></tr><tr><td>time_constant</td><td>s</td><td>required</td><td>0</td><td></td><td>Thermal time constant</td></tr><tr><td>coefficient</td><td>1/K</td><td>0</td><td></td><td></td><td>Relative change of the gain per kelvin</td></tr><tr><td>growth</td><td>{position}/K</td><td>0</td><td></td><td></td><td>Change of the position per kelvin</td></tr><tr><td>amplification</td><td>1</td><td>1</td><td></td><td></td><td>Voltage per command</td></tr><tr><td>averaging</td><td>s</td><td>1</td><td>0</td><td></td><td>Time over which the mean voltage is taken</td></tr></table><p>Source: K. Uchino, S. Hirose, IEEE Trans. UFFC 48 (2001) 307-321.</p><p>Effect: <code>self_heating</code>.</p><p>In the residual: slow drift that depends on the power of the drive (frequency times voltage squared).</p><p>Looks like: <code>thermal_drift</code>, <code>creep</code>.</p><p>Distinguished by: alternate high and low power at the same mean.</p></html>"));
  end SelfHeating;

  block ThermalPort "Thermal port of the actuator: temperature from outside, heat of its losses as output"
    extends Interfaces.PositionFilter;
    parameter Real growth(unit="um/K") "Change of the position per kelvin";
    parameter Real loss(unit="1", min = 0) "Loss tangent";
    parameter Real capacitance(unit="C/V", min = 0) "Capacitance";
    parameter Real coefficient(unit="1/K") = 0 "Relative change of the gain per kelvin";
    parameter Real reference(unit="K", min = 0) = 293.15 "Temperature without change";
    parameter Real averaging(unit="s", min = 0) = 1 "Time over which the mean voltage is taken";
    Interfaces.TemperatureInput actuator_temperature "Temperature of the actuator" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.CommandInput voltage "Voltage at the actuator" annotation(Placement(transformation(extent={{40,-120},{80,-80}})));
    output Real heat(unit="W", quantity="Power") "Heat that flows out of the actuator";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real last(start = 0, fixed = true, unit="V") "Voltage at the last sample";
    discrete Real mean(start = 0, fixed = true, unit="V") "Mean voltage";
    discrete Real middle(start = 0, fixed = true, unit="V") "Alternating voltage in the middle of the step";
    discrete Real P(start = 0, fixed = true, unit="W") "Loss";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      last = voltage;
      middle = if pre(on) then 0.5*(last + pre(last)) - pre(mean) else 0;
      P = if pre(on) then Constants.pi/2*loss*capacitance*abs(middle*(last - pre(last)))/step else 0;
      mean = if pre(on) then pre(mean) + (1 - exp(-step/averaging))*(last - pre(mean)) else last;
    end when;
    y_um = u_um*(1 + coefficient*(actuator_temperature - reference)) + growth*(actuator_temperature - reference);
    heat = P;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-20,-60},{-20,40},{0,60},{20,40},{20,-60},{0,-80},{-20,-60}}, color={191,0,0}, thickness=0.5), Line(points={{0,-60},{0,20}}, color={191,0,0}, thickness=1), Line(points={{30,0},{80,0},{66,10},{80,0},{66,-10}}, color={191,0,0})}),
      Documentation(info="<html><p>Component <code>thermal-port</code>. Thermal port of the actuator: temperature from outside, heat of its losses as output.</p><p><code>y = x*(1 + coefficient*(T - reference)) + growth*(T - reference); heat = pi/2*loss*capacitance*|(v - mean(v))*v'|</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>growth</td><td>{position}/K</td><td>required</td><td></td><td></td><td>Change of the position per kelvin</td></tr><tr><td>loss</td><td>1</td><td>required</td><td>0</td><td></td><td>Loss tangent</td></tr><tr><td>capacitance</td><td>C/{command}</td><td>required</td><td>0</td><td></td><td>Capacitance</td></tr><tr><td>coefficient</td><td>1/K</td><td>0</td><td></td><td></td><td>Relative change of the gain per kelvin</td></tr><tr><td>reference</td><td>K</td><td>293.15</td><td>0</td><td></td><td>Temperature without change</td></tr><tr><td>averaging</td><td>s</td><td>1</td><td>0</td><td></td><td>Time over which the mean voltage is taken</td></tr></table><p>Source: K. Uchino, S. Hirose, IEEE Trans. UFFC 48 (2001) 307-321.</p></html>"));
  end ThermalPort;

  block Remanence "Remanence of an unknown past, which fades until the command has wiped it out"
    extends Interfaces.PositionFilter;
    parameter Real remanence(unit="um") "Difference at the start";
    parameter Real reach(unit="V", min = 0) "Excursion of the command that wipes it out";
    Interfaces.CommandInput command "Command of the axis" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-59},{8,9},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>remanence</code>. Remanence of an unknown past, which fades until the command has wiped it out.</p><p><code>y = x + remanence*max(0, 1 - w/reach); w = max |u(s) - u(0)|, s &lt;= t</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>remanence</td><td>{position}</td><td>required</td><td></td><td></td><td>Difference at the start</td></tr><tr><td>reach</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Excursion of the command that wipes it out</td></tr></table><p>Source: I. D. Mayergoyz, Mathematical Models of Hysteresis and Their Applications, 2003.</p><p>Effect: <code>initial_state</code>.</p><p>In the residual: only until the first full reversal.</p><p>Looks like: <code>hysteresis</code>, <code>thermal_drift</code>.</p><p>Distinguished by: a run-in cycle before the record, then compare.</p></html>"));
  end Remanence;
  annotation(Documentation(info="<html><p>The actuator apart from its memory.</p></html>"));
end Actuator;

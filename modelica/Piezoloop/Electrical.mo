within Piezoloop;
package Electrical "Amplifier and electrical port"
  extends Icons.Package;
  block AmplifierLag "First-order bandwidth of the amplifier into the actuator's capacitance"
    extends Interfaces.CommandFilter(y(start = 0, fixed = true));
    parameter Real bandwidth(unit="Hz", min = 0) "Frequency at which the gain has fallen by 3 dB";
    parameter Real gain(unit="1") = 1 "Gain at low frequency";
  equation
    when initial() then
      reinit(y, gain*u);
    end when;
    der(y)/(2*Constants.pi*bandwidth) + y = gain*u;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-69,39},{-66,59},{-62,67},{-51,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>amplifier-lag</code>. First-order bandwidth of the amplifier into the actuator's capacitance.</p><p><code>v'/(2*pi*bandwidth) + v = gain*u</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>bandwidth</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Frequency at which the gain has fallen by 3 dB</td></tr><tr><td>gain</td><td>1</td><td>1</td><td></td><td></td><td>Gain at low frequency</td></tr></table><p>Source: A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning Systems, Springer 2014, ch. 14.</p><p>Effect: <code>amplifier_bandwidth</code>.</p><p>In the residual: phase from a tenth of the bandwidth on, independent of amplitude.</p><p>Looks like: <code>sensor_bandwidth</code>, <code>delay</code>, <code>rate_dependence</code>.</p><p>Distinguished by: record the amplifier's monitor voltage; or large signals at a high rate, where a lag in front of the hysteresis shrinks its loop.</p><p>In <code>p0-truth</code>: 0.600 % at most, 0.358 % rms.</p><p>In <code>p1-truth</code>: 80.636 % at most, 45.770 % rms.</p><p>In <code>p2-truth</code>: 3.316 % at most, 1.354 % rms.</p><p>In <code>p3-truth</code>: 81.026 % at most, 47.953 % rms.</p><p>In <code>p4-truth</code>: 2.190 % at most, 1.263 % rms.</p><p>In <code>evc-truth</code>: 2.301 % at most, 1.127 % rms.</p></html>"));
  end AmplifierLag;

  block AmplifierSecondOrder "Second-order bandwidth of the amplifier into the actuator's capacitance"
    extends Interfaces.CommandFilter(y(start = 0, fixed = true));
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency";
    parameter Real damping(unit="1", min = 0) "Damping ratio; 0.707 is flat";
    parameter Real gain(unit="1") = 1 "Gain at low frequency";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real v(start = 0, fixed = true, unit="V") "Rate of y over w";
  equation
    when initial() then
      reinit(y, gain*u);
    end when;
    der(y) = w*v;
    der(v) = w*(gain*u - y - 2*damping*v);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,-64},{-68,39},{-65,70},{-59,59},{-55,57},{80,58}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>amplifier-second-order</code>. Second-order bandwidth of the amplifier into the actuator's capacitance.</p><p><code>v'' + 2*damping*w*v' + w^2*v = w^2*gain*u; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio; 0.707 is flat</td></tr><tr><td>gain</td><td>1</td><td>1</td><td></td><td></td><td>Gain at low frequency</td></tr></table><p>Source: A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning Systems, Springer 2014, ch. 14.</p><p>Effect: <code>amplifier_bandwidth</code>.</p><p>In the residual: phase from a tenth of the bandwidth on, independent of amplitude.</p><p>Looks like: <code>sensor_bandwidth</code>, <code>delay</code>, <code>rate_dependence</code>.</p><p>Distinguished by: record the amplifier's monitor voltage; or large signals at a high rate, where a lag in front of the hysteresis shrinks its loop.</p></html>"));
  end AmplifierSecondOrder;

  block AmplifierRc "Output resistance and current limit into the capacitance of a moving actuator"
    extends Interfaces.CommandFilter;
    parameter Real resistance(unit="Ohm", min = 0) "Output resistance";
    parameter Real capacitance(unit="F", min = 0) "Capacitance of the actuator";
    parameter Real current(unit="A", min = 0) "Greatest current";
    parameter Real gain(unit="1") = 1 "Gain at low frequency";
    parameter Real transduction(unit="C/um") = 0 "Charge per displacement; 0 for none";
    Interfaces.PositionInput displacement "Displacement behind the mechanics" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
  protected
    Real displacement_um(unit="um") = displacement/Constants.um "displacement in um";
    Real i(unit="A") "Current into the actuator";
  initial equation
    y = gain*u;
  equation
    i = min(max((gain*u - y)/resistance, -current), current);
    capacitance*der(y) + transduction*der(displacement_um) = i;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-53,60},{-50,68},{-42,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>amplifier-rc</code>. Output resistance and current limit into the capacitance of a moving actuator.</p><p><code>capacitance*v' + transduction*x' = i; i = min(max((gain*u - v)/resistance, -current), current)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>resistance</td><td>Ohm</td><td>required</td><td>0</td><td></td><td>Output resistance</td></tr><tr><td>capacitance</td><td>F</td><td>required</td><td>0</td><td></td><td>Capacitance of the actuator</td></tr><tr><td>current</td><td>A</td><td>required</td><td>0</td><td></td><td>Greatest current</td></tr><tr><td>gain</td><td>1</td><td>1</td><td></td><td></td><td>Gain at low frequency</td></tr><tr><td>transduction</td><td>C/{position}</td><td>0</td><td></td><td></td><td>Charge per displacement; 0 for none</td></tr></table><p>Source: A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning Systems, Springer 2014, ch. 14.</p><p>Effect: <code>amplifier_bandwidth</code>.</p><p>In the residual: phase from a tenth of the bandwidth on, independent of amplitude.</p><p>Looks like: <code>sensor_bandwidth</code>, <code>delay</code>, <code>rate_dependence</code>.</p><p>Distinguished by: record the amplifier's monitor voltage; or large signals at a high rate, where a lag in front of the hysteresis shrinks its loop.</p></html>"));
  end AmplifierRc;

  block AmplifierSlew "Current limit of the amplifier, as a limit of the slope"
    extends Interfaces.CommandFilter;
    parameter Real rate(unit="V/s", min = 0) "Greatest slope";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real v(start = 0, fixed = true, unit="V") "Voltage at the end of the step";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      v = if pre(on) then pre(v) + min(max(u - pre(v), -rate*step), rate*step) else u;
    end when;
    y = v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-24,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>amplifier-slew</code>. Current limit of the amplifier, as a limit of the slope.</p><p><code>v' = min(max((u - v)/T, -rate), rate)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>rate</td><td>{command}/s</td><td>required</td><td>0</td><td></td><td>Greatest slope</td></tr></table><p>Source: A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning Systems, Springer 2014, ch. 14.</p><p>Effect: <code>amplifier_slew</code>.</p><p>In the residual: only large and fast signals: a sine becomes triangular, third harmonic; zero below a threshold of the slope.</p><p>Looks like: <code>rate_dependence</code>, <code>amplifier_saturation</code>.</p><p>Distinguished by: the same frequency at half the amplitude: it disappears at once.</p></html>"));
  end AmplifierSlew;

  block AmplifierFoldback "Average current limit of the amplifier, which acts after sustained fast driving"
    extends Interfaces.CommandFilter;
    parameter Real continuous(unit="A", min = 0) "Greatest rms current";
    parameter Real peak(unit="A", min = 0) "Greatest current at any time";
    parameter Real capacitance(unit="C/V", min = 0) "Capacitance of the actuator";
    parameter Real time_constant(unit="s", min = 0) = 1 "Averaging time of the rms current";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real v(start = 0, fixed = true, unit="V") "Voltage at the end of the step";
    discrete Real q(start = 0, fixed = true, unit="A2") "Mean square of the current";
    discrete Real most(start = 0, fixed = true, unit="V") "Greatest way in this step";
    discrete Real way(start = 0, fixed = true, unit="V") "Way of this step";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      most = step/capacitance*(if pre(q) <= continuous^2 then peak else continuous);
      way = if pre(on) then min(max(u - pre(v), -most), most) else 0;
      v = if pre(on) then pre(v) + way else u;
      q = pre(q) + (1 - exp(-step/time_constant))*((capacitance*way/step)^2 - pre(q));
    end when;
    y = v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-62,-10},{-20,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>amplifier-foldback</code>. Average current limit of the amplifier, which acts after sustained fast driving.</p><p><code>|v'| &lt;= i/capacitance; i = peak while q &lt;= continuous^2, else continuous; time_constant*q' = (capacitance*v')^2 - q</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>continuous</td><td>A</td><td>required</td><td>0</td><td></td><td>Greatest rms current</td></tr><tr><td>peak</td><td>A</td><td>required</td><td>0</td><td></td><td>Greatest current at any time</td></tr><tr><td>capacitance</td><td>C/{command}</td><td>required</td><td>0</td><td></td><td>Capacitance of the actuator</td></tr><tr><td>time_constant</td><td>s</td><td>1</td><td>0</td><td></td><td>Averaging time of the rms current</td></tr></table><p>Source: A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning Systems, Springer 2014, ch. 14.</p><p>Effect: <code>amplifier_slew</code>.</p><p>In the residual: only large and fast signals: a sine becomes triangular, third harmonic; zero below a threshold of the slope.</p><p>Looks like: <code>rate_dependence</code>, <code>amplifier_saturation</code>.</p><p>Distinguished by: the same frequency at half the amplitude: it disappears at once.</p></html>"));
  end AmplifierFoldback;

  block AmplifierClamp "Voltage limits of the amplifier, hard or soft"
    extends Interfaces.CommandFilter;
    parameter Real low(unit="V") "Least voltage";
    parameter Real high(unit="V") "Greatest voltage";
    parameter Real softness(unit="V", min = 0) = 0 "Half width of the bend at each limit";
  protected
    Real above(unit="V") "What the upper bend takes away";
    Real below(unit="V") "What the lower bend adds";
  equation
    above = Functions.excess(u - high, softness);
    below = Functions.excess(low - u, softness);
    y = u - above + below;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-67,-65},{8,13},{80,70},{66,70},{57,65},{-65,-63},{-72,-69},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>amplifier-clamp</code>. Voltage limits of the amplifier, hard or soft.</p><p><code>v = min(max(u, low), high), with a parabola within softness of a limit</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>low</td><td>{command}</td><td>required</td><td></td><td></td><td>Least voltage</td></tr><tr><td>high</td><td>{command}</td><td>required</td><td></td><td></td><td>Greatest voltage</td></tr><tr><td>softness</td><td>{command}</td><td>0</td><td>0</td><td></td><td>Half width of the bend at each limit</td></tr></table><p>Source: A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning Systems, Springer 2014, ch. 14.</p><p>Effect: <code>amplifier_saturation</code>.</p><p>In the residual: flat top at one end of the range; zero inside.</p><p>Looks like: <code>polarisation_saturation</code>, <code>sensor_nonlinearity</code>.</p><p>Distinguished by: reduce the offset of the command; histogram of the position.</p></html>"));
  end AmplifierClamp;

  block AmplifierNonlinearity "Offset and integral nonlinearity of converter and amplifier"
    extends Interfaces.CommandFilter;
    parameter Real offset(unit="V") = 0 "Voltage at zero command";
    parameter Real quadratic(unit="1") = 0 "Quadratic deviation at the end of the range";
    parameter Real cubic(unit="1") = 0 "Cubic deviation at the end of the range";
    parameter Real centre(unit="V") "Middle of the range";
    parameter Real half_range(unit="V", min = 0) "Half of the range";
  protected
    Real xi(unit="1") "Place in the range, -1 to 1";
  equation
    xi = (u - centre)/half_range;
    y = u + offset + half_range*(quadratic*xi^2 + cubic*xi^3);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>amplifier-nonlinearity</code>. Offset and integral nonlinearity of converter and amplifier.</p><p><code>v = u + offset + half_range*(quadratic*xi^2 + cubic*xi^3); xi = (u - centre)/half_range</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>offset</td><td>{command}</td><td>0</td><td></td><td></td><td>Voltage at zero command</td></tr><tr><td>quadratic</td><td>1</td><td>0</td><td></td><td></td><td>Quadratic deviation at the end of the range</td></tr><tr><td>cubic</td><td>1</td><td>0</td><td></td><td></td><td>Cubic deviation at the end of the range</td></tr><tr><td>centre</td><td>{command}</td><td>required</td><td></td><td></td><td>Middle of the range</td></tr><tr><td>half_range</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Half of the range</td></tr></table><p>Source: IEEE Std 1241, Terminology and Test Methods for Analog-to-Digital Converters.</p><p>Effect: <code>sensor_nonlinearity</code>.</p><p>In the residual: a polynomial of the position, the same on both branches and at every rate.</p><p>Looks like: <code>asymmetry</code>, <code>polarisation_saturation</code>, <code>amplifier_saturation</code>.</p><p>Distinguished by: interferometer as reference; shift the working range.</p></html>"));
  end AmplifierNonlinearity;

  block PiezoCharge "Electrical port of the actuator: voltage, charge and current as outputs"
    extends Interfaces.CommandFilter;
    parameter Real capacitance(unit="C/V", min = 0) "Capacitance at constant length";
    parameter Real transduction(unit="C/um") = 0 "Charge per displacement";
    Interfaces.PositionInput displacement "Displacement behind the mechanics" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.CommandOutput voltage "Voltage at the actuator" annotation(Placement(transformation(extent={{100,40},{120,60}})));
    output Real charge(unit="C", quantity="ElectricCharge") "Charge on the actuator";
    output Real current(unit="A", quantity="ElectricCurrent") "Current into the actuator, mean of the step";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real displacement_um(unit="um") = displacement/Constants.um "displacement in um";
    discrete Real q(start = 0, fixed = true, unit="C") "Charge at the last sample";
    discrete Real i(start = 0, fixed = true, unit="A") "Mean current of the last step";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      q = capacitance*u + transduction*displacement_um;
      i = if pre(on) then (q - pre(q))/step else 0;
    end when;
    y = u;
    voltage = u;
    charge = q;
    current = i;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>piezo-charge</code>. Electrical port of the actuator: voltage, charge and current as outputs.</p><p><code>q = capacitance*v + transduction*x; i = dq/dt</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>capacitance</td><td>C/{command}</td><td>required</td><td>0</td><td></td><td>Capacitance at constant length</td></tr><tr><td>transduction</td><td>C/{position}</td><td>0</td><td></td><td></td><td>Charge per displacement</td></tr></table><p>Source: M. Goldfarb, N. Celanovic, IEEE Control Systems 17 (1997) 69-79.</p></html>"));
  end PiezoCharge;
  package Analog "Components with pins: plug-compatible with Modelica.Electrical.Analog"
    extends Icons.Package;

    model Ground "Potential zero"
      Interfaces.PositivePin p "Pin at potential zero" annotation(Placement(transformation(extent={{-10,90},{10,110}})));
    equation
      p.v = 0;
      annotation(Icon(graphics={Line(points={{0,90},{0,30}}, color={0,0,255}), Line(points={{-60,30},{60,30}}, color={0,0,255}), Line(points={{-40,0},{40,0}}, color={0,0,255}), Line(points={{-20,-30},{20,-30}}, color={0,0,255}), Text(extent={{-150,-80},{150,-40}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>p.v = 0</code>. Every electrical circuit needs one.</p></html>"));
    end Ground;

    model Amplifier "Voltage amplifier with output resistance and current limit"
      Interfaces.CommandInput u "Command" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
      Interfaces.PositivePin p "Output" annotation(Placement(transformation(extent={{90,50},{110,70}})));
      Interfaces.NegativePin n "Return" annotation(Placement(transformation(extent={{90,-70},{110,-50}})));
      parameter Real gain(unit="1") = 1 "Output voltage per command without load";
      parameter Real resistance(unit="Ohm", min = 0) = 50 "Output resistance";
      parameter Real current(unit="A", min = 0) = 1 "Greatest current";
      Types.Current i "Current into the load";
      Types.Energy delivered(start = 0, fixed = true) "Energy into the load";
    equation
      i = max(-current, min(current, (gain*u - (p.v - n.v))/resistance));
      p.i = -i;
      n.i = i;
      der(delivered) = (p.v - n.v)*i;
      annotation(Icon(graphics={Polygon(points={{-80,80},{-80,-80},{80,0}}, lineColor={0,0,127}, fillColor={255,255,255}, fillPattern=FillPattern.Solid), Line(points={{40,20},{40,60},{90,60}}, color={0,0,255}), Line(points={{40,-20},{40,-60},{90,-60}}, color={0,0,255}), Text(extent={{-150,90},{150,130}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>i = clamp((gain*u - v)/resistance, +-current)</code>. Into a stack of capacitance C the small-signal bandwidth is 1/(2*pi*resistance*C); large steps run into the current limit, with slope current/C. Look-alikes: <code>AmplifierRc</code> is the same as a block, <code>AmplifierLag</code> without the limit.</p></html>"));
    end Amplifier;

    model PiezoStack "Piezo stack: voltage and charge on one side, force and motion on the other"
      extends Interfaces.TwoPins;
      Interfaces.Flange_a flange_a "Base" annotation(Placement(transformation(extent={{-110,-70},{-90,-50}})));
      Interfaces.Flange_b flange_b "Tip" annotation(Placement(transformation(extent={{90,-70},{110,-50}})));
      parameter Real stiffness(unit="N/m", min = 0) = 5e7 "Stiffness with constant voltage";
      parameter Real stroke_per_volt(unit="m/V") = 1e-7 "Free stroke per voltage";
      parameter Real capacitance(unit="F", min = 0) = 5e-6 "Capacitance when blocked; free it is larger by stiffness*stroke_per_volt^2";
      parameter Real damping(unit="N.s/m", min = 0) = 0 "Internal damping";
      parameter Real length(unit="m", min = 0) = 0 "Length at rest";
      Types.Position s(displayUnit="um") "Elongation";
      Types.Charge q "Charge";
      Types.Force f "Pull on the tip";
      Types.Energy stored "Elastic and electric energy";
      Types.Energy dissipated(start = 0, fixed = true) "Loss in the damping";
    equation
      s = flange_b.s - flange_a.s - length;
      f = stiffness*(s - stroke_per_volt*v) + damping*der(s);
      q = capacitance*v + stiffness*stroke_per_volt*s;
      i = der(q);
      flange_b.f = f;
      flange_a.f = -f;
      stored = 0.5*stiffness*s^2 + 0.5*capacitance*v^2;
      der(dissipated) = damping*der(s)^2;
      annotation(Icon(graphics={Rectangle(extent={{-80,-90},{80,-30}}, lineColor={0,0,0}, fillColor={230,159,0}, fillPattern=FillPattern.Solid), Line(points={{-60,-90},{-60,-30}}), Line(points={{-40,-90},{-40,-30}}), Line(points={{-20,-90},{-20,-30}}), Line(points={{0,-90},{0,-30}}), Line(points={{20,-90},{20,-30}}), Line(points={{40,-90},{40,-30}}), Line(points={{60,-90},{60,-30}}), Line(points={{-90,0},{-70,0},{-70,-30}}, color={0,0,255}), Line(points={{90,0},{70,0},{70,-30}}, color={0,0,255}), Text(extent={{-150,30},{150,70}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>f = k*(s - d*v) + c*s'; q = C*v + k*d*s; i = q'</code>, the linear constitutive equations of a stack with k = <code>stiffness</code>, d = <code>stroke_per_volt</code>. Free stroke d*v, blocking force k*d*v. Without damping the stack is lossless: v*i and the force's power change <code>stored</code> only. Valid where hysteresis does not matter; put a block of <code>Hysteresis</code> in front of the command, or use the blocks. Source: IEEE Std 176-1987, IEEE Standard on Piezoelectricity, for one dimension.</p></html>"));
    end PiezoStack;
    annotation(Documentation(info="<html><p>Amplifier and stack with pins and flanges. Parameters are in SI.</p></html>"));
  end Analog;
  annotation(Documentation(info="<html><p>Amplifiers as blocks; <code>Analog</code>: with pins.</p></html>"));
end Electrical;

within Piezoloop;
package Controllers "Control laws"
  extends Icons.Package;
  block ReferenceLead "Adds the first and second derivative of the reference, for lags and a mode"
    extends Interfaces.ReferenceFilter;
    parameter Real lag(unit="s", min = 0) "Sum of the path's time constants and delays";
    parameter Real inertia(unit="s2", min = 0) "Second-order coefficient, 1/omega^2 for one mode";
    parameter Real limit(unit="um", min = 0) "Greatest correction in either direction";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real last(start = 0, fixed = true, unit="um") "Reference at this sample";
    discrete Real before(start = 0, fixed = true, unit="um") "Reference one sample before";
    discrete Real lead(start = 0, fixed = true, unit="um") "What is added";
  equation
    when sample(0, step) then
      on = true;
      last = u_um;
      before = if pre(on) then pre(last) else u_um;
      lead = if pre(on) then max(-limit, min(limit, (1.5*lag/step + inertia/step^2)*(u_um - pre(last))
        - (0.5*lag/step + inertia/step^2)*(pre(last) - pre(before)))) else 0;
    end when;
    y_um = last + lead;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-37,-37},{8,-6},{80,70},{80,22},{80,45},{0,-17},{-57,-56},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>reference-lead</code>. Adds the first and second derivative of the reference, for lags and a mode.</p><p><code>y = r + clamp(lag*r' + inertia*r'', +-limit)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>lag</td><td>s</td><td>required</td><td>0</td><td></td><td>Sum of the path's time constants and delays</td></tr><tr><td>inertia</td><td>s2</td><td>required</td><td>0</td><td></td><td>Second-order coefficient, 1/omega^2 for one mode</td></tr><tr><td>limit</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Greatest correction in either direction</td></tr></table><p>Source: S. Devasia, E. Eleftheriou, S. O. R. Moheimani, IEEE Trans. Control Syst. Technol. 15 (2007) 802-823.</p></html>"));
  end ReferenceLead;

  block ReferenceCurve "Curve through points before the feedforward, for a static nonlinearity of the sensor"
    extends Interfaces.ReferenceFilter;
    parameter Integer points(min = 2, max = 4096) "Number of points";
    parameter Real at[points](each unit="um") "Inputs of the points, increasing";
    parameter Real value[points](each unit="um") "Output at each point";
  equation
    y_um = Functions.curve(u_um, at, value);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-35,-36},{8,8},{80,70},{31,31},{-35,-36},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>reference-curve</code>. Curve through points before the feedforward, for a static nonlinearity of the sensor.</p><p><code>y = value[i] + (value[i+1] - value[i])/(at[i+1] - at[i])*(u - at[i]); at[i] &lt;= u &lt; at[i+1], the first and the last interval without end</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>points` (structure)</td><td>1</td><td>by its lists</td><td>2</td><td>4096</td><td>Number of points</td></tr><tr><td>at</td><td>{position}</td><td>required</td><td></td><td></td><td>Inputs of the points, increasing</td></tr><tr><td>value</td><td>{position}</td><td>required</td><td></td><td></td><td>Output at each point</td></tr></table><p>Source: G. Tao, P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley 1996, ch. 2.</p></html>"));
  end ReferenceCurve;

  block CommandCurve "Curve through points behind the feedforward, for a static nonlinearity of the amplifier"
    extends Interfaces.CommandFilter;
    parameter Integer points(min = 2, max = 4096) "Number of points";
    parameter Real at[points](each unit="V") "Inputs of the points, increasing";
    parameter Real value[points](each unit="V") "Output at each point";
  equation
    y = Functions.curve(u, at, value);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-24,-29},{80,70},{58,53},{-25,-29},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>command-curve</code>. Curve through points behind the feedforward, for a static nonlinearity of the amplifier.</p><p><code>y = value[i] + (value[i+1] - value[i])/(at[i+1] - at[i])*(u - at[i]); at[i] &lt;= u &lt; at[i+1], the first and the last interval without end</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>points` (structure)</td><td>1</td><td>by its lists</td><td>2</td><td>4096</td><td>Number of points</td></tr><tr><td>at</td><td>{command}</td><td>required</td><td></td><td></td><td>Inputs of the points, increasing</td></tr><tr><td>value</td><td>{command}</td><td>required</td><td></td><td></td><td>Output at each point</td></tr></table><p>Source: G. Tao, P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley 1996, ch. 2.</p></html>"));
  end CommandCurve;

  block FeedforwardGain "Linear feedforward: command proportional to the reference position"
    extends Interfaces.Inverse;
    parameter Real gain(unit="V/um") "Command per position";
    parameter Real offset(unit="um") = 0 "Position at zero command";
  equation
    y = gain*(u_um - offset);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>feedforward-gain</code>. Linear feedforward: command proportional to the reference position.</p><p><code>u = gain*(y - offset)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{command}/{position}</td><td>required</td><td></td><td></td><td>Command per position</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command</td></tr></table><p>Source: inverse of a linear actuator.</p></html>"));
  end FeedforwardGain;

  block Pid "PID with feedforward, output and rate limits, anti-windup and bumpless enabling"
    extends Interfaces.Controller;
    parameter Real kp(unit="V/um") "Proportional gain";
    parameter Real ki(unit="V/(um.s)") = 0 "Integral gain";
    parameter Real kd(unit="V.s/um") = 0 "Derivative gain";
    parameter Real derivative_filter(unit="s", min = 0) = 0 "Time constant of the derivative's filter, 0 for none";
    parameter Real output_min(unit="V") "Least command";
    parameter Real output_max(unit="V") "Greatest command";
    parameter Real feedforward_gain(unit="1") = 1 "Share of the feedforward that is added";
    parameter Real rate_max(unit="V/s", min = 0) = 0 "Greatest rate of the command, 0 for no limit";
    parameter Real tracking_time(unit="s", min = 0) = 0 "Time constant of anti-windup by back-calculation, 0 for conditional integration";
    parameter Real hold(unit="1", min = 0, max = 1) = 1 "While disabled: 1 holds the last command, 0 ramps to the safe command at the rate limit";
    parameter Real safe(unit="V") = 0 "Command while disabled, if hold is 0";
    Interfaces.PositionInput reference "Reference position" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.PositionInput measured "Position that is measured" annotation(Placement(transformation(extent={{-40,-120},{0,-80}})));
    input Boolean enable "False holds the command or goes to the safe one" annotation(Placement(transformation(extent={{0,-120},{40,-80}})));
    Interfaces.CommandOutput feedforward "Feedforward before the limits" annotation(Placement(transformation(extent={{100,70},{120,90}})));
    Interfaces.CommandOutput feedback "Feedback before the limits" annotation(Placement(transformation(extent={{100,-50},{120,-30}})));
    output Boolean saturated "The command is at a limit" annotation(Placement(transformation(extent={{100,-90},{120,-70}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real reference_um(unit="um") = reference/Constants.um "reference in um";
    Real measured_um(unit="um") = measured/Constants.um "measured in um";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Boolean was_enabled(start = true, fixed = true) "Enabled at the last sample";
    discrete Real e(start = 0, fixed = true, unit="um") "Error";
    discrete Real last(start = 0, fixed = true, unit="um") "Error one sample before";
    discrete Real q(start = 0, fixed = true, unit="um/s") "Filtered derivative of the error";
    discrete Real ff(start = 0, fixed = true, unit="V") "Feedforward";
    discrete Real before(start = 0, fixed = true, unit="V") "Command one sample before";
    discrete Real I0(start = 0, fixed = true, unit="V") "Integral before this sample";
    discrete Real I(start = 0, fixed = true, unit="V") "Integral";
    discrete Real free(start = 0, fixed = true, unit="V") "Command before the limits";
    discrete Real held(start = 0, fixed = true, unit="V") "Command";
    final parameter Real f(unit="1") = if derivative_filter > 0 then exp(-step/derivative_filter) else 0
      "What the filter keeps in a step";
  equation
    when sample(0, step) then
      on = true;
      was_enabled = enable;
      e = reference_um - measured_um;
      last = if pre(on) and pre(was_enabled) then pre(e) else e;
      q = if not enable then pre(q) elseif pre(was_enabled) then f*pre(q) + (1 - f)*(e - last)/step else 0;
      ff = feedforward_gain*u;
      before = if pre(on) then pre(held)
        else max(output_min, min(output_max, if enable or hold > 0 then ff else safe));
      I0 = if not pre(on) then 0 elseif enable and not pre(was_enabled) then before - ff - (kp + ki*step)*e else pre(I);
      free = if enable then ff + kp*e + I0 + ki*step*e + kd*q elseif hold > 0 then before else safe;
      held = Functions.limited(free, before, output_min, output_max, rate_max*step);
      I = if not enable then I0 elseif tracking_time > 0 then I0 + ki*step*e + step/tracking_time*(held - free)
        elseif (free > held and ki*e > 0) or (free < held and ki*e < 0) then I0 else I0 + ki*step*e;
    end when;
    y = held;
    feedforward = ff;
    feedback = if enable then free - ff else 0;
    saturated = enable and (free > held or free < held);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,20},{-71,11},{-66,10},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>pid</code>. PID with feedforward, output and rate limits, anti-windup and bumpless enabling.</p><p><code>u = feedforward_gain*u_ff + kp*e + I + kd*q; I = I + ki*T*e; q = f*q + (1 - f)*(e - e_last)/T; f = exp(-T/derivative_filter); e = reference - measured; command = min(max(u, output_min), output_max), at most rate_max*T from the last</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>kp</td><td>{command}/{position}</td><td>required</td><td></td><td></td><td>Proportional gain</td></tr><tr><td>ki</td><td>{command}/{position}/s</td><td>0</td><td></td><td></td><td>Integral gain</td></tr><tr><td>kd</td><td>{command}.s/{position}</td><td>0</td><td></td><td></td><td>Derivative gain</td></tr><tr><td>derivative_filter</td><td>s</td><td>0</td><td>0</td><td></td><td>Time constant of the derivative's filter, 0 for none</td></tr><tr><td>output_min</td><td>{command}</td><td>required</td><td>of the commands</td><td>of the commands</td><td>Least command</td></tr><tr><td>output_max</td><td>{command}</td><td>required</td><td>of the commands</td><td>of the commands</td><td>Greatest command</td></tr><tr><td>feedforward_gain</td><td>1</td><td>1</td><td></td><td></td><td>Share of the feedforward that is added</td></tr><tr><td>rate_max</td><td>{command}/s</td><td>0</td><td>0</td><td></td><td>Greatest rate of the command, 0 for no limit</td></tr><tr><td>tracking_time</td><td>s</td><td>0</td><td>0</td><td></td><td>Time constant of anti-windup by back-calculation, 0 for conditional integration</td></tr><tr><td>hold</td><td>1</td><td>1</td><td>0</td><td>1</td><td>While disabled: 1 holds the last command, 0 ramps to the safe command at the rate limit</td></tr><tr><td>safe</td><td>{command}</td><td>0</td><td></td><td></td><td>Command while disabled, if hold is 0</td></tr></table><p>Source: K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ch. 3 and 13.</p></html>"));
  end Pid;

  block IncrementalPid "PID in incremental form with feedforward, output and rate limits, bumpless enabling"
    extends Interfaces.Controller;
    parameter Real kp(unit="V/um") "Proportional gain";
    parameter Real ki(unit="V/(um.s)") = 0 "Integral gain";
    parameter Real kd(unit="V.s/um") = 0 "Derivative gain";
    parameter Real output_min(unit="V") "Least command";
    parameter Real output_max(unit="V") "Greatest command";
    parameter Real feedforward_gain(unit="1") = 1 "Share of the feedforward that is added";
    parameter Real rate_max(unit="V/s", min = 0) = 0 "Greatest rate of the command, 0 for no limit";
    parameter Real hold(unit="1", min = 0, max = 1) = 1 "While disabled: 1 holds the last command, 0 ramps to the safe command at the rate limit";
    parameter Real safe(unit="V") = 0 "Command while disabled, if hold is 0";
    Interfaces.PositionInput reference "Reference position" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.PositionInput measured "Position that is measured" annotation(Placement(transformation(extent={{-40,-120},{0,-80}})));
    input Boolean enable "False holds the command or goes to the safe one" annotation(Placement(transformation(extent={{0,-120},{40,-80}})));
    Interfaces.CommandOutput feedforward "Feedforward before the limits" annotation(Placement(transformation(extent={{100,70},{120,90}})));
    Interfaces.CommandOutput feedback "Feedback before the limits" annotation(Placement(transformation(extent={{100,-50},{120,-30}})));
    output Boolean saturated "The command is at a limit" annotation(Placement(transformation(extent={{100,-90},{120,-70}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real reference_um(unit="um") = reference/Constants.um "reference in um";
    Real measured_um(unit="um") = measured/Constants.um "measured in um";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Boolean was_enabled(start = true, fixed = true) "Enabled at the last sample";
    discrete Real e(start = 0, fixed = true, unit="um") "Error";
    discrete Real difference(start = 0, fixed = true, unit="um") "Its change since the last sample";
    discrete Real second(start = 0, fixed = true, unit="um") "The change of that";
    discrete Real ff(start = 0, fixed = true, unit="V") "Feedforward";
    discrete Real before(start = 0, fixed = true, unit="V") "Command one sample before";
    discrete Real v0(start = 0, fixed = true, unit="V") "Sum before this sample";
    discrete Real v(start = 0, fixed = true, unit="V") "Sum of the increments that acted";
    discrete Real free(start = 0, fixed = true, unit="V") "Command before the limits";
    discrete Real held(start = 0, fixed = true, unit="V") "Command";
  equation
    when sample(0, step) then
      on = true;
      was_enabled = enable;
      e = reference_um - measured_um;
      difference = if pre(on) and pre(was_enabled) then e - pre(e) else 0;
      second = if pre(on) and pre(was_enabled) then difference - pre(difference) else 0;
      ff = feedforward_gain*u;
      before = if pre(on) then pre(held)
        else max(output_min, min(output_max, if enable or hold > 0 then ff else safe));
      v0 = if not pre(on) then 0 elseif enable and not pre(was_enabled) then before - ff - ki*step*e else pre(v);
      free = if enable then ff + v0 + kp*difference + ki*step*e + kd/step*second elseif hold > 0 then before else safe;
      held = Functions.limited(free, before, output_min, output_max, rate_max*step);
      v = if enable then held - ff else v0;
    end when;
    y = held;
    feedforward = ff;
    feedback = if enable then free - ff else 0;
    saturated = enable and (free > held or free < held);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,41},{-72,9},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>incremental-pid</code>. PID in incremental form with feedforward, output and rate limits, bumpless enabling.</p><p><code>u = feedforward_gain*u_ff + v; v = v_last + kp*(e - e1) + ki*T*e + kd/T*(e - 2*e1 + e2); e = reference - measured; command = min(max(u, output_min), output_max), at most rate_max*T from the last</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>kp</td><td>{command}/{position}</td><td>required</td><td></td><td></td><td>Proportional gain</td></tr><tr><td>ki</td><td>{command}/{position}/s</td><td>0</td><td></td><td></td><td>Integral gain</td></tr><tr><td>kd</td><td>{command}.s/{position}</td><td>0</td><td></td><td></td><td>Derivative gain</td></tr><tr><td>output_min</td><td>{command}</td><td>required</td><td>of the commands</td><td>of the commands</td><td>Least command</td></tr><tr><td>output_max</td><td>{command}</td><td>required</td><td>of the commands</td><td>of the commands</td><td>Greatest command</td></tr><tr><td>feedforward_gain</td><td>1</td><td>1</td><td></td><td></td><td>Share of the feedforward that is added</td></tr><tr><td>rate_max</td><td>{command}/s</td><td>0</td><td>0</td><td></td><td>Greatest rate of the command, 0 for no limit</td></tr><tr><td>hold</td><td>1</td><td>1</td><td>0</td><td>1</td><td>While disabled: 1 holds the last command, 0 ramps to the safe command at the rate limit</td></tr><tr><td>safe</td><td>{command}</td><td>0</td><td></td><td></td><td>Command while disabled, if hold is 0</td></tr></table><p>Source: LS-SVM with stop operators tuned by particle swarm, eqs. (22), (23).</p></html>"));
  end IncrementalPid;

  block BoucWenFeedforward "Feedforward that uses a Bouc-Wen model itself, without an inverse"
    extends Interfaces.Inverse;
    parameter Real gain(unit="um/V") "D, position per command without hysteresis";
    parameter Real alpha(unit="1") "Share of the hysteresis";
    parameter Real beta(unit="1/V") "Shape of the loop";
    parameter Real gamma(unit="1/V") "Shape of the loop";
    parameter Real lag(unit="s", min = 0) = 0 "B/K";
    parameter Real inertia(unit="s2", min = 0) = 0 "M/K";
    parameter Real limit(unit="um", min = 0) = 1000000000.0 "Greatest amount that the derivatives add";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real wanted(start = 0, fixed = true, unit="um") "Reference position";
    discrete Real difference(start = 0, fixed = true, unit="um") "Its change since the last sample";
    discrete Real before(start = 0, fixed = true, unit="V") "Command one sample before";
    discrete Real force(start = 0, fixed = true, unit="um") "What the change of the command must make up for";
    discrete Real slope(start = 1, fixed = true, unit="um/V") "Slope of the model in the direction of the change";
    discrete Real h(start = 0, fixed = true, unit="um") "Hysteretic part";
    discrete Real command(start = 0, fixed = true, unit="V") "Command";
  equation
    when sample(0, step) then
      on = true;
      wanted = u_um;
      difference = if pre(on) then u_um - pre(wanted) else 0;
      before = if pre(on) then pre(command) else u_um/gain;
      force = u_um + max(-limit, min(limit, lag/step*difference + inertia/step^2*(difference - pre(difference))))
        + pre(h) - gain*before;
      slope = gain - (alpha*gain - beta*(if force*gain >= 0 then 1 else -1)*pre(h) - gamma*abs(pre(h)));
      command = before + (if slope*gain > 1e-3*gain^2 then force/slope else force/gain);
      h = pre(h) + (gain - slope)*(command - before);
    end when;
    y = command;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,65},{-73,65},{-73,70},{-72,-70},{-71,-52},{-65,-51},{-63,-19},{80,-19}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>bouc-wen-feedforward</code>. Feedforward that uses a Bouc-Wen model itself, without an inverse.</p><p><code>D*u = inertia*y'' + lag*y' + y + H; H' = alpha*D*u' - beta*|u'|*H - gamma*u'*|H|</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>D, position per command without hysteresis</td></tr><tr><td>alpha</td><td>1</td><td>required</td><td></td><td></td><td>Share of the hysteresis</td></tr><tr><td>beta</td><td>1/{command}</td><td>required</td><td></td><td></td><td>Shape of the loop</td></tr><tr><td>gamma</td><td>1/{command}</td><td>required</td><td></td><td></td><td>Shape of the loop</td></tr><tr><td>lag</td><td>s</td><td>0</td><td>0</td><td></td><td>B/K</td></tr><tr><td>inertia</td><td>s2</td><td>0</td><td>0</td><td></td><td>M/K</td></tr><tr><td>limit</td><td>{position}</td><td>1000000000</td><td>0</td><td></td><td>Greatest amount that the derivatives add</td></tr></table><p>Source: Q. Xu, IEEE Trans. Ind. Electron. 60 (2013) 3927-3937, eqs. (1), (2), (4).</p></html>"));
  end BoucWenFeedforward;

  block Notch "Notch filter against a resonance"
    extends Interfaces.PathFilter;
    parameter Real frequency(unit="Hz", min = 0) "Frequency of the notch";
    parameter Real damping(unit="1", min = 0) = 0.5 "Damping ratio of the poles";
    parameter Real depth(unit="1", min = 0, max = 1) = 0 "Gain at that frequency";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    final parameter Real w(unit="1") = tan(Constants.pi*frequency*step) "Frequency of the bilinear transform";
    final parameter Real total(unit="1") = 1 + w^2 + 2*damping*w "Divisor of the coefficients";
    final parameter Real b0(unit="1") = (1 + w^2 + 2*depth*damping*w)/total "Coefficient of the input";
    final parameter Real b1(unit="1") = 2*(w^2 - 1)/total "Coefficient of the last input and output";
    final parameter Real b2(unit="1") = (1 + w^2 - 2*depth*damping*w)/total "Coefficient of the input before";
    final parameter Real a2(unit="1") = (1 + w^2 - 2*damping*w)/total "Coefficient of the output before";
    discrete Real v(start = 0, fixed = true) "Output";
    discrete Real first(start = 0, fixed = true) "What past samples add to the next output";
    discrete Real second(start = 0, fixed = true) "What they add to the one behind it";
  equation
    when sample(0, step) then
      on = true;
      v = if pre(on) then b0*u + pre(first) else u;
      first = if pre(on) then b1*(u - v) + pre(second) else (1 - b0)*u;
      second = b2*u - a2*v;
    end when;
    y = v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,44},{-70,2},{-62,70},{-54,52},{-46,57},{80,56}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>notch</code>. Notch filter against a resonance.</p><p><code>y = (s^2 + 2*damping*depth*w*s + w^2)/(s^2 + 2*damping*w*s + w^2)*u; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Frequency of the notch</td></tr><tr><td>damping</td><td>1</td><td>0.5</td><td>0</td><td></td><td>Damping ratio of the poles</td></tr><tr><td>depth</td><td>1</td><td>0</td><td>0</td><td>1</td><td>Gain at that frequency</td></tr></table><p>Source: K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ch. 8.</p></html>"));
  end Notch;

  block ReferenceFilter "Second-order low-pass for the reference of both feedforward and feedback"
    extends Interfaces.ReferenceFilter;
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency";
    parameter Real damping(unit="1", min = 0.1) = 1 "Damping ratio";
    Interfaces.PositionOutput reference "Reference for the control law behind it" annotation(Placement(transformation(extent={{100,50},{120,70}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real reference_um(unit="um") "reference in um";
    final parameter Real angle(unit="1") = 2*Constants.pi*frequency*step "Angle in a step";
    final parameter Real even(unit="1") = Functions.transitionEven(angle, damping) "Transition in a step, even part";
    final parameter Real odd(unit="1") = Functions.transitionOdd(angle, damping) "Transition in a step, odd part";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real e0(start = 0, fixed = true, unit="um") "Distance from the reference before this step";
    discrete Real x(start = 0, fixed = true, unit="um") "Filtered reference";
    discrete Real v(start = 0, fixed = true, unit="um") "Its rate over the angular frequency";
  equation
    reference = Constants.um*reference_um;
    when sample(0, step) then
      on = true;
      e0 = if pre(on) then pre(x) - u_um else 0;
      x = u_um + (even + damping*odd)*e0 + odd*pre(v);
      v = (even - damping*odd)*pre(v) - odd*e0;
    end when;
    y_um = x;
    reference_um = x;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-72,-66},{-60,38},{-55,57},{-49,68},{-43,70},{-20,68},{80,68}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>reference-filter</code>. Second-order low-pass for the reference of both feedforward and feedback.</p><p><code>r_f + 2*damping*r_f'/w + r_f''/w^2 = r; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency</td></tr><tr><td>damping</td><td>1</td><td>1</td><td>0.1</td><td></td><td>Damping ratio</td></tr></table><p>Source: K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ch. 5.</p></html>"));
  end ReferenceFilter;

  block ReferencePreview "Preview of the reference: feedforward uses it at once, feedback later"
    extends Interfaces.ReferenceFilter;
    parameter Real longest(unit="s", min = 0, max = 10) = 0.01 "Longest preview that can be set";
    parameter Real preview(unit="s", min = 0) "Time by which the reference input is ahead";
    parameter Integer cells(min = 2) = 502 "Samples that are kept: longest/step + 2";
    Interfaces.PositionOutput reference "Reference for the control law behind it" annotation(Placement(transformation(extent={{100,50},{120,70}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real reference_um(unit="um") "reference in um";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real past[cells](each start = 0, each fixed = true, each unit="um") "The references so far, newest first";
    discrete Real ahead(start = 0, fixed = true, unit="um") "Reference at this sample";
    discrete Real later(start = 0, fixed = true, unit="um") "Reference of so long ago";
  equation
    reference = Constants.um*reference_um;
    when sample(0, step) then
      on = true;
      ahead = u_um;
      past = Functions.shift(u_um, if pre(on) then 1 else 0, pre(past));
      later = Functions.interpolate(preview/step, past);
    end when;
    y_um = ahead;
    reference_um = later;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>reference-preview</code>. Preview of the reference: feedforward uses it at once, feedback later.</p><p><code>path = r(t); reference = r(t - preview)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>longest` (structure)</td><td>s</td><td>0.01</td><td>0</td><td>10</td><td>Longest preview that can be set</td></tr><tr><td>preview</td><td>s</td><td>required</td><td>0</td><td>longest</td><td>Time by which the reference input is ahead</td></tr></table><p>Source: M. Tomizuka, ASME J. Dyn. Syst. Meas. Control 115 (1993) 412-418.</p></html>"));
  end ReferencePreview;

  block DisturbanceObserver "Estimates the machine's deviation from its model and subtracts it from the reference, before the inverse"
    extends Interfaces.ReferenceFilter;
    parameter Real longest(unit="s", min = 0, max = 10) = 0.1 "Longest delay that can be set";
    parameter Real bandwidth(unit="Hz", min = 0) "Frequency up to which disturbances are compensated";
    parameter Real lag(unit="s", min = 0) = 0 "Time constant from the inverse to the measured position";
    parameter Real delay_(unit="s", min = 0) = 0 "Dead time from the inverse to the measured position";
    parameter Real limit(unit="um", min = 0) "Greatest disturbance that is compensated";
    parameter Integer cells(min = 2) = 5002 "Samples that are kept: longest/step + 2";
    Interfaces.PositionInput measured "Position that is measured" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    input Boolean enable "False takes nothing off" annotation(Placement(transformation(extent={{-40,-120},{0,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real measured_um(unit="um") = measured/Constants.um "measured in um";
    final parameter Real low_pass(unit="1") = 1 - exp(-2*Constants.pi*bandwidth*step) "What Q takes up in a step";
    final parameter Real follow(unit="1") = if lag > 0 then 1 - exp(-step/lag) else 1 "What the lag takes up in a step";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real past[cells](each start = 0, each fixed = true, each unit="um") "What went to the inverse, newest first";
    discrete Real before(start = 0, fixed = true, unit="um") "Position by the model one sample before";
    discrete Real m(start = 0, fixed = true, unit="um") "Position by the model";
    discrete Real d(start = 0, fixed = true, unit="um") "Disturbance";
    discrete Real v(start = 0, fixed = true, unit="um") "Reference less the disturbance";
  equation
    when sample(0, step) then
      on = true;
      past = Functions.shift(if pre(on) then pre(v) else u_um, if pre(on) then 1 else 0, pre(past));
      before = if pre(on) then pre(m) else u_um;
      m = before + follow*(Functions.interpolate(delay_/step, past) - before);
      d = if enable then max(-limit, min(limit, pre(d) + low_pass*(measured_um - m - pre(d)))) else 0;
      v = u_um - d;
    end when;
    y_um = v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,36},{-68,22},{-63,22},{-35,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>disturbance-observer</code>. Estimates the machine's deviation from its model and subtracts it from the reference, before the inverse.</p><p><code>v = r - d; d = Q*(measured - M*v); M = exp(-s*delay)/(1 + s*lag); Q = 1/(1 + s/(2*pi*bandwidth)); |d| &lt;= limit</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>longest` (structure)</td><td>s</td><td>0.1</td><td>0</td><td>10</td><td>Longest delay that can be set</td></tr><tr><td>bandwidth</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Frequency up to which disturbances are compensated</td></tr><tr><td>lag</td><td>s</td><td>0</td><td>0</td><td></td><td>Time constant from the inverse to the measured position</td></tr><tr><td>delay</td><td>s</td><td>0</td><td>0</td><td>longest</td><td>Dead time from the inverse to the measured position</td></tr><tr><td>limit</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Greatest disturbance that is compensated</td></tr></table><p>Source: K. Ohnishi, M. Shibata, T. Murakami, IEEE/ASME Trans. Mechatronics 1 (1996) 56-67.</p></html>"));
  end DisturbanceObserver;

  block Repetitive "Repetitive (iterative learning) control of a periodic reference"
    extends Interfaces.Controller;
    parameter Real cycle(unit="s", min = 1e-09, max = 1000000.0) "Period of the reference, a whole number of sample times";
    parameter Integer half(min = 0, max = 1000) = 10 "Half length of the window, in samples";
    parameter Real gain(unit="V/um") "Learning gain";
    parameter Real lead(unit="s", min = 0) = 0 "Delay from the command to the measured position";
    parameter Real keep(unit="1", min = 0, max = 1) = 1 "Share of the learned command that is kept for the next cycle";
    parameter Real limit(unit="V", min = 0) "Greatest command that is learned";
    parameter Integer cells(min = 2) = 1010 "Samples that are kept: cycle/step + half; the default is for a cycle of 0.02 s";
    Interfaces.PositionInput reference "Reference position" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.PositionInput measured "Position that is measured" annotation(Placement(transformation(extent={{-40,-120},{0,-80}})));
    input Boolean enable "False adds and learns nothing" annotation(Placement(transformation(extent={{0,-120},{40,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real reference_um(unit="um") = reference/Constants.um "reference in um";
    Real measured_um(unit="um") = measured/Constants.um "measured in um";
    final parameter Real ahead(unit="1") = Functions.round(lead/step) "Samples of the lead";
    discrete Real errors[cells](each start = 0, each fixed = true, each unit="um") "Errors so far, newest first";
    discrete Real learned[cells](each start = 0, each fixed = true, each unit="V") "Learned commands so far, newest first";
    discrete Real w(start = 0, fixed = true, unit="V") "Learned command";
    discrete Real held(start = 0, fixed = true, unit="V") "Command";
  equation
    when sample(0, step) then
      w = if enable then max(-limit, min(limit, keep*Functions.window(half, pre(learned))
        + gain*Functions.interpolate(cells - half - ahead - 1, pre(errors)))) else 0;
      errors = Functions.shift(if enable then reference_um - measured_um else 0, 1, pre(errors));
      learned = Functions.shift(w, 1, pre(learned));
      held = u + w;
    end when;
    y = held;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,43},{-39,43},{-38,59},{-5,59},{-1,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>repetitive</code>. Repetitive (iterative learning) control of a periodic reference.</p><p><code>w(k) = keep*sum(h[j]*w(k-N+j)) + gain*e(k-N+lead); e = reference - measured; command = path + w</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>cycle` (structure)</td><td>s</td><td>by its lists</td><td>0.000000001</td><td>1000000</td><td>Period of the reference, a whole number of sample times</td></tr><tr><td>half` (structure)</td><td>1</td><td>10</td><td>0</td><td>1000</td><td>Half length of the window, in samples</td></tr><tr><td>gain</td><td>{command}/{position}</td><td>required</td><td></td><td></td><td>Learning gain</td></tr><tr><td>lead</td><td>s</td><td>0</td><td>0</td><td></td><td>Delay from the command to the measured position</td></tr><tr><td>keep</td><td>1</td><td>1</td><td>0</td><td>1</td><td>Share of the learned command that is kept for the next cycle</td></tr><tr><td>limit</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Greatest command that is learned</td></tr></table><p>Source: D. A. Bristow, M. Tharayil, A. G. Alleyne, IEEE Control Systems 26 (2006) 96-114.</p></html>"));
  end Repetitive;

  block IntegralResonantControl "Integral resonant control: a low-pass of the position in positive feedback damps a resonance"
    extends Interfaces.Controller;
    parameter Real gain(unit="V/um") "Static gain of the feedback";
    parameter Real frequency(unit="Hz", min = 0) "Corner frequency of the low-pass";
    parameter Real setpoint_weight(unit="1", min = 0, max = 1) = 1 "Share of the reference that is subtracted from the measured position; 1 with an inverse as feedforward";
    Interfaces.PositionInput reference "Reference position" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.PositionInput measured "Position that is measured" annotation(Placement(transformation(extent={{-40,-120},{0,-80}})));
    input Boolean enable "False adds nothing" annotation(Placement(transformation(extent={{0,-120},{40,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real position_um(unit="um") = (measured - setpoint_weight*reference)/Constants.um "What is fed back in um";
    final parameter Real w(unit="1") = tan(Constants.pi*frequency*step) "Frequency of the bilinear transform";
    final parameter Real a1(unit="1") = (w - 1)/(1 + w) "Coefficient of the last output";
    final parameter Real b0(unit="1") = w/(1 + w) "Coefficient of the input";
    final parameter Real b1(unit="1") = w/(1 + w) "Coefficient of the last input";
    discrete Boolean on(start = false, fixed = true) "The loop was closed at the last sample";
    discrete Real origin(start = 0, fixed = true, unit="um") "Position where it was closed";
    discrete Real moved(start = 0, fixed = true, unit="um") "Position from there";
    discrete Real filtered(start = 0, fixed = true, unit="um") "Filtered position";
    discrete Real first(start = 0, fixed = true, unit="um") "What past samples add to the next output";
    discrete Real held(start = 0, fixed = true, unit="V") "Command";
  equation
    when sample(0, step) then
      on = enable;
      origin = if enable and not pre(on) then position_um else pre(origin);
      moved = if enable then position_um - origin else 0;
      filtered = if enable then b0*moved + pre(first) else 0;
      first = if enable then b1*moved - a1*filtered else 0;
      held = u + gain*filtered;
    end when;
    y = held;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,43},{-39,30},{-5,40},{80,36}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>integral-resonant-control</code>. Integral resonant control: a low-pass of the position in positive feedback damps a resonance.</p><p><code>y = u + gain*F*(x - x0); F = w/(s + w); w = 2*pi*frequency; x = measured - setpoint_weight*reference; x0 = x at rest and where the loop was closed</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{command}/{position}</td><td>required</td><td></td><td></td><td>Static gain of the feedback</td></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Corner frequency of the low-pass</td></tr><tr><td>setpoint_weight</td><td>1</td><td>1</td><td>0</td><td>1</td><td>Share of the reference that is subtracted from the measured position; 1 with an inverse as feedforward</td></tr></table><p>Source: S. S. Aphale, A. J. Fleming, S. O. R. Moheimani, Smart Mater. Struct. 16 (2007) 439-446.</p></html>"));
  end IntegralResonantControl;

  block PositivePositionFeedback "Positive position feedback: a resonant low-pass of the position damps a resonance"
    extends Interfaces.Controller;
    parameter Real gain(unit="V/um") "Static gain of the feedback";
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency of the filter";
    parameter Real damping(unit="1", min = 0) "Damping ratio of the filter";
    parameter Real setpoint_weight(unit="1", min = 0, max = 1) = 1 "Share of the reference that is subtracted from the measured position; 1 with an inverse as feedforward";
    Interfaces.PositionInput reference "Reference position" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.PositionInput measured "Position that is measured" annotation(Placement(transformation(extent={{-40,-120},{0,-80}})));
    input Boolean enable "False adds nothing" annotation(Placement(transformation(extent={{0,-120},{40,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real position_um(unit="um") = (measured - setpoint_weight*reference)/Constants.um "What is fed back in um";
    final parameter Real w(unit="1") = tan(Constants.pi*frequency*step) "Frequency of the bilinear transform";
    final parameter Real total(unit="1") = 1 + w^2 + 2*damping*w "Divisor of the coefficients";
    final parameter Real b0(unit="1") = w^2/total "Coefficient of the input";
    final parameter Real b1(unit="1") = 2*w^2/total "Coefficient of the last input";
    final parameter Real b2(unit="1") = w^2/total "Coefficient of the input before";
    final parameter Real a1(unit="1") = 2*(w^2 - 1)/total "Coefficient of the last output";
    final parameter Real a2(unit="1") = (1 + w^2 - 2*damping*w)/total "Coefficient of the output before";
    discrete Boolean on(start = false, fixed = true) "The loop was closed at the last sample";
    discrete Real origin(start = 0, fixed = true, unit="um") "Position where it was closed";
    discrete Real moved(start = 0, fixed = true, unit="um") "Position from there";
    discrete Real filtered(start = 0, fixed = true, unit="um") "Filtered position";
    discrete Real first(start = 0, fixed = true, unit="um") "What past samples add to the next output";
    discrete Real second(start = 0, fixed = true, unit="um") "What they add to the one behind it";
    discrete Real held(start = 0, fixed = true, unit="V") "Command";
  equation
    when sample(0, step) then
      on = enable;
      origin = if enable and not pre(on) then position_um else pre(origin);
      moved = if enable then position_um - origin else 0;
      filtered = if enable then b0*moved + pre(first) else 0;
      first = if enable then b1*moved - a1*filtered + pre(second) else 0;
      second = if enable then b2*moved - a2*filtered else 0;
      held = u + gain*filtered;
    end when;
    y = held;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-60,60},{-45,10},{-25,45},{0,30},{80,36}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>positive-position-feedback</code>. Positive position feedback: a resonant low-pass of the position damps a resonance.</p><p><code>y = u + gain*F*(x - x0); F = w^2/(s^2 + 2*damping*w*s + w^2); w = 2*pi*frequency; x = measured - setpoint_weight*reference; x0 = x at rest and where the loop was closed</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{command}/{position}</td><td>required</td><td></td><td></td><td>Static gain of the feedback</td></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency of the filter</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio of the filter</td></tr><tr><td>setpoint_weight</td><td>1</td><td>1</td><td>0</td><td>1</td><td>Share of the reference that is subtracted from the measured position; 1 with an inverse as feedforward</td></tr></table><p>Source: J. L. Fanson, T. K. Caughey, AIAA J. 28 (1990) 717-724.</p></html>"));
  end PositivePositionFeedback;

  block NonMinimumPhaseDamping "Non-minimum-phase damping: feedback of the position through an all-pass, with constant gain and shifted phase"
    extends Interfaces.Controller;
    parameter Real gain(unit="V/um") "Static gain of the feedback";
    parameter Real frequency(unit="Hz", min = 0) "Frequency at which the phase of the all-pass is -90 degrees";
    parameter Real setpoint_weight(unit="1", min = 0, max = 1) = 1 "Share of the reference that is subtracted from the measured position; 1 with an inverse as feedforward";
    Interfaces.PositionInput reference "Reference position" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.PositionInput measured "Position that is measured" annotation(Placement(transformation(extent={{-40,-120},{0,-80}})));
    input Boolean enable "False adds nothing" annotation(Placement(transformation(extent={{0,-120},{40,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real position_um(unit="um") = (measured - setpoint_weight*reference)/Constants.um "What is fed back in um";
    final parameter Real w(unit="1") = tan(Constants.pi*frequency*step) "Frequency of the bilinear transform";
    final parameter Real a1(unit="1") = (w - 1)/(1 + w) "Coefficient of the last output";
    final parameter Real b0(unit="1") = (w - 1)/(1 + w) "Coefficient of the input";
    final parameter Real b1(unit="1") = 1 "Coefficient of the last input";
    discrete Boolean on(start = false, fixed = true) "The loop was closed at the last sample";
    discrete Real origin(start = 0, fixed = true, unit="um") "Position where it was closed";
    discrete Real moved(start = 0, fixed = true, unit="um") "Position from there";
    discrete Real filtered(start = 0, fixed = true, unit="um") "Filtered position";
    discrete Real first(start = 0, fixed = true, unit="um") "What past samples add to the next output";
    discrete Real held(start = 0, fixed = true, unit="V") "Command";
  equation
    when sample(0, step) then
      on = enable;
      origin = if enable and not pre(on) then position_um else pre(origin);
      moved = if enable then position_um - origin else 0;
      filtered = if enable then b0*moved + pre(first) else 0;
      first = if enable then b1*moved - a1*filtered else 0;
      held = u + gain*filtered;
    end when;
    y = held;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-30},{-73,-30},{-73,-70},{-50,20},{-20,60},{80,66}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>non-minimum-phase-damping</code>. Non-minimum-phase damping: feedback of the position through an all-pass, with constant gain and shifted phase.</p><p><code>y = u + gain*F*(x - x0); F = (w - s)/(w + s); w = 2*pi*frequency; x = measured - setpoint_weight*reference; x0 = x at rest and where the loop was closed</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{command}/{position}</td><td>required</td><td></td><td></td><td>Static gain of the feedback</td></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Frequency at which the phase of the all-pass is -90 degrees</td></tr><tr><td>setpoint_weight</td><td>1</td><td>1</td><td>0</td><td>1</td><td>Share of the reference that is subtracted from the measured position; 1 with an inverse as feedforward</td></tr></table><p>Source: A. Natu, H. HosseinNia, arXiv 2412.18374 (2024).</p></html>"));
  end NonMinimumPhaseDamping;

  block JacobianCoordinator "From the coordinates of all sensors to the motions of all axes, through the inverse Jacobian"
    extends Icons.Block;
    parameter Integer axes(min = 2, max = 32) "Number of coupled axes";
    parameter Integer entries(min = 4, max = 1024) "Number of entries of the matrix";
    parameter Real matrix[entries](each unit="um/V") "Jacobian, row by row";
    parameter Real offset[axes](each unit="um") "Coordinates at zero motion";
    parameter Real condition_max(unit="1", min = 1) = 1000 "Greatest condition number of the Jacobian that is taken";
    Interfaces.PositionInput u[axes] "Coordinates that are wanted" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionInput measured[axes] "Coordinates that are measured" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.PositionOutput y[axes] "Motions that are wanted, the reference behind it" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    Interfaces.PositionOutput measured_motion[axes] "Motions that are measured, the measured position behind it" annotation(Placement(transformation(extent={{100,-70},{120,-50}})));
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real measured_um[axes](each unit="um") = measured/Constants.um "measured in um";
    Real y_um[axes](each unit="um") "y in um";
    Real measured_motion_um[axes](each unit="um") "measured_motion in um";
    final parameter Real inverse[entries](each unit="V/um") = Functions.inverseMatrix(matrix, offset) "Inverse Jacobian";
  equation
    y = Constants.um*y_um;
    measured_motion = Constants.um*measured_motion_um;
    for i in 1:axes loop
      y_um[i] = Functions.rowDifference(inverse, i, u_um, offset);
      measured_motion_um[i] = Functions.rowDifference(inverse, i, measured_um, offset);
    end for;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>jacobian-coordinator</code>. From the coordinates of all sensors to the motions of all axes, through the inverse Jacobian.</p><p><code>theta_r = J^-1*(p_r - p0); theta_m = J^-1*(p - p0); J[i,j] = matrix[i,j]; p0[i] = offset[i]</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>axes` (structure)</td><td>1</td><td>by its lists</td><td>2</td><td>32</td><td>Number of coupled axes</td></tr><tr><td>entries` (structure)</td><td>1</td><td>by its lists</td><td>4</td><td>1024</td><td>Number of entries of the matrix</td></tr><tr><td>matrix</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Jacobian, row by row</td></tr><tr><td>offset</td><td>{position}</td><td>required</td><td></td><td></td><td>Coordinates at zero motion</td></tr><tr><td>condition_max</td><td>1</td><td>1000</td><td>1</td><td></td><td>Greatest condition number of the Jacobian that is taken</td></tr></table><p>Source: laser beam pointing with four piezo axes, eqs. (14), (18), (19).</p></html>"));
  end JacobianCoordinator;
  annotation(Documentation(info="<html><p>Control laws.</p></html>"));
end Controllers;

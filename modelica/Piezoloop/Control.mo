within Piezoloop;
package Control "Control laws"
  block ReferenceLead "Adds the first and second derivative of the reference, for lags and a mode"
    extends Interfaces.ReferenceFilter;
    parameter Real lag(unit="s", min = 0) "Sum of the path's time constants and delays";
    parameter Real inertia(unit="s2", min = 0) "Second-order coefficient, 1/omega^2 for one mode";
    parameter Real limit(unit="um", min = 0) "Greatest amount that is added or taken away";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real last(start = 0, fixed = true, unit="um") "Reference at this sample";
    discrete Real before(start = 0, fixed = true, unit="um") "Reference one sample before";
    discrete Real lead(start = 0, fixed = true, unit="um") "What is added";
  equation
    when sample(0, step) then
      on = true;
      last = u;
      before = if pre(on) then pre(last) else u;
      lead = if pre(on) then max(-limit, min(limit, (1.5*lag/step + inertia/step^2)*(u - pre(last))
        - (0.5*lag/step + inertia/step^2)*(pre(last) - pre(before)))) else 0;
    end when;
    y = last + lead;
    annotation(Documentation(info="<html><p>Component <code>reference-lead</code>:</p><p><code>y = r + clamp(lag*r' + inertia*r'', +-limit)</code></p></html>"));
  end ReferenceLead;

  block FeedforwardGain "Linear feedforward: command proportional to the position that is wanted"
    extends Interfaces.Inverse;
    parameter Real gain(unit="V/um") "Command per position";
    parameter Real offset(unit="um") = 0 "Position at zero command";
  equation
    y = gain*(u - offset);
    annotation(Documentation(info="<html><p>Component <code>feedforward-gain</code>:</p><p><code>u = gain*(y - offset)</code></p></html>"));
  end FeedforwardGain;

  block Pid "PID with feedforward, output limits, anti-windup and bumpless enabling"
    extends Interfaces.Controller;
    parameter Real kp(unit="V/um") "Proportional gain";
    parameter Real ki(unit="V/(um.s)") = 0 "Integral gain";
    parameter Real kd(unit="V.s/um") = 0 "Derivative gain";
    parameter Real derivative_filter(unit="s", min = 0) = 0 "Time constant of the derivative's filter, 0 for none";
    parameter Real output_min(unit="V") "Least command";
    parameter Real output_max(unit="V") "Greatest command";
    Interfaces.PositionInput reference "Position that is wanted";
    Interfaces.PositionInput measured "Position that is measured";
    input Boolean enable "False holds the command";
    Interfaces.CommandOutput feedforward "Feedforward before the limits";
    Interfaces.CommandOutput feedback "Feedback before the limits";
    output Boolean saturated "The command is at a limit";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Boolean was_enabled(start = true, fixed = true) "Enabled at the last sample";
    discrete Real e(start = 0, fixed = true, unit="um") "Error";
    discrete Real last(start = 0, fixed = true, unit="um") "Error one sample before";
    discrete Real q(start = 0, fixed = true, unit="um/s") "Filtered derivative of the error";
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
      e = reference - measured;
      last = if pre(on) and pre(was_enabled) then pre(e) else e;
      q = if not enable then pre(q) elseif pre(was_enabled) then f*pre(q) + (1 - f)*(e - last)/step else 0;
      I0 = if not pre(on) then 0 elseif enable and not pre(was_enabled) then pre(held) - u - (kp + ki*step)*e else pre(I);
      free = if enable then u + kp*e + I0 + ki*step*e + kd*q else pre(held);
      I = if not enable or (free > output_max and ki*e > 0) or (free < output_min and ki*e < 0) then I0
        else I0 + ki*step*e;
      held = max(output_min, min(output_max, free));
    end when;
    y = held;
    feedforward = u;
    feedback = if enable then free - u else 0;
    saturated = enable and (free > output_max or free < output_min);
    annotation(Documentation(info="<html><p>Component <code>pid</code>:</p><p><code>u = u_ff + kp*e + I + kd*q; I = I + ki*T*e; q = f*q + (1 - f)*(e - e_last)/T; f = exp(-T/derivative_filter); e = reference - measured; command = min(max(u, output_min), output_max)</code></p></html>"));
  end Pid;
end Control;

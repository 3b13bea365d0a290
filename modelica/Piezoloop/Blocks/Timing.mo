within Piezoloop.Blocks;
package Timing "Delay, clock and converter of the command"
  extends Icons.Package;
  block Delay "Transport delay (computing, bus, converter), also by a fraction of a step"
    extends Interfaces.CommandFilter;
    parameter Real longest(unit="s", min = 0, max = 10) = 0.01 "Longest delay that can be set";
    parameter Real delay_(unit="s", min = 0) "Delay";
    parameter Integer cells(min = 2) = 502 "Samples that are kept: longest/step + 2";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real past[cells](each start = 0, each fixed = true, each unit="V") "The inputs so far, newest first";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real v(start = 0, fixed = true, unit="V") "Delayed input, mean of the step";
  equation
    when sample(0, step) then
      on = true;
      past = Functions.shift(u, if pre(on) then 1 else 0, pre(past));
      v = Functions.interpolate(delay_/step, past);
    end when;
    y = v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-71,-70},{-70,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>delay</code>. Transport delay (computing, bus, converter), also by a fraction of a step.</p><p><code>y(t) = u(t - delay)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>longest` (structure)</td><td>s</td><td>0.01</td><td>0</td><td>10</td><td>Longest delay that can be set</td></tr><tr><td>delay</td><td>s</td><td>required</td><td>0</td><td>longest</td><td>Delay</td></tr></table><p>Source: K. J. Astrom, B. Wittenmark, Computer-Controlled Systems, 3rd ed. 1997, ch. 2.</p><p>Effect: <code>delay</code>.</p><p>In the residual: phase falls linearly with frequency at every amplitude; a step starts late.</p><p>Looks like: <code>amplifier_bandwidth</code>, <code>sensor_bandwidth</code>.</p><p>Distinguished by: phase over frequency: a delay is straight up to the Nyquist frequency; onset of a step.</p><p>In <code>p0-truth</code>: 1.441 % at most, 0.854 % rms.</p></html>"));
  end Delay;

  block ClockOffset "Offset and jitter of the sample clock, as a delay that changes"
    extends Interfaces.CommandFilter;
    parameter Real longest(unit="s", min = 0, max = 10) = 0.01 "Longest delay";
    parameter Real initial_(unit="s", min = 0) = 0 "Delay at the start";
    parameter Real offset(unit="1") = 0 "Relative clock error";
    parameter Real jitter(unit="s", min = 0) = 0 "Standard deviation of the jitter";
    parameter Integer cells(min = 2) = 502 "Samples that are kept: longest/step + 2";
    Interfaces.NoiseInput n "Independent normal number of each step" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real past[cells](each start = 0, each fixed = true, each unit="V") "The inputs so far, newest first";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real v(start = 0, fixed = true, unit="V") "Delayed input, mean of the step";
  equation
    when sample(0, step) then
      on = true;
      past = Functions.shift(u, if pre(on) then 1 else 0, pre(past));
      v = Functions.interpolate(max(0, min(longest, initial_ + offset*(time + step) + jitter*n))/step, past);
    end when;
    y = v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-72,-70},{-71,-60},{-71,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>clock-offset</code>. Offset and jitter of the sample clock, as a delay that changes.</p><p><code>y(t) = u(t - d); d = initial + offset*t + jitter*n</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>longest` (structure)</td><td>s</td><td>0.01</td><td>0</td><td>10</td><td>Longest delay</td></tr><tr><td>initial</td><td>s</td><td>0</td><td>0</td><td>longest</td><td>Delay at the start</td></tr><tr><td>offset</td><td>1</td><td>0</td><td></td><td></td><td>Relative clock error</td></tr><tr><td>jitter</td><td>s</td><td>0</td><td>0</td><td></td><td>Standard deviation of the jitter</td></tr><tr><td>seed</td><td>1</td><td>1</td><td></td><td></td><td>Seed of the jitter</td></tr></table><p>Source: IEEE Std 1241, Terminology and Test Methods for Analog-to-Digital Converters.</p><p>Effect: <code>clock_offset</code>.</p><p>In the residual: grows with record time times slope of the signal; jitter looks like noise that grows with frequency and amplitude.</p><p>Looks like: <code>delay</code>, <code>thermal_drift</code>.</p><p>Distinguished by: compare the times of edges at the start and at the end of a long record.</p></html>"));
  end ClockOffset;

  block DacQuantisation "Resolution of the command's converter"
    extends Interfaces.CommandFilter;
    parameter Real resolution(unit="V", min = 0) "Step of the converter: range over 2^bits";
    parameter Real phase(unit="1") = 0 "Place of the codes between two multiples of the resolution";
  equation
    y = resolution*(Functions.round(u/resolution - phase) + phase);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-67,-70},{-67,-47},{-40,-47},{-40,-23},{-13,-23},{-13,0},{13,0},{13,23},{40,23},{40,47},{67,47},{67,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>dac-quantisation</code>. Resolution of the command's converter.</p><p><code>y = resolution*(round(x/resolution - phase) + phase)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>resolution</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Step of the converter: range over 2^bits</td></tr><tr><td>phase</td><td>1</td><td>0</td><td></td><td></td><td>Place of the codes between two multiples of the resolution</td></tr></table><p>Source: B. Widrow, I. Kollar, Quantization Noise, Cambridge University Press 2008.</p><p>Effect: <code>dac_quantisation</code>.</p><p>In the residual: stairs at small signals, a fixed function of the command; visible only where a step exceeds the noise.</p><p>Looks like: <code>sensor_noise</code>, <code>friction</code>.</p><p>Distinguished by: a slow ramp over a few steps of the converter.</p><p>In <code>p0-truth</code>: 0.030 % at most, 0.002 % rms.</p><p>In <code>p1-truth</code>: 4.2e-4 % at most, 1.2e-4 % rms.</p></html>"));
  end DacQuantisation;
  annotation(Documentation(info="<html><p>Delay, clock and converter of the command.</p></html>"));
end Timing;

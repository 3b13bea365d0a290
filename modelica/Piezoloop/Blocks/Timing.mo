within Piezoloop.Blocks;
package Timing "Delay, clock and converter of the command"
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
    annotation(Documentation(info="<html><p>Component <code>delay</code>:</p><p><code>y(t) = u(t - delay)</code></p></html>"));
  end Delay;

  block ClockOffset "Offset and jitter of the sample clock, as a delay that changes"
    extends Interfaces.CommandFilter;
    parameter Real longest(unit="s", min = 0, max = 10) = 0.01 "Longest delay";
    parameter Real initial_(unit="s", min = 0) = 0 "Delay at the start";
    parameter Real offset(unit="1") = 0 "Relative clock error";
    parameter Real jitter(unit="s", min = 0) = 0 "Standard deviation of the jitter";
    parameter Integer cells(min = 2) = 502 "Samples that are kept: longest/step + 2";
    Interfaces.NoiseInput n "Independent normal number of each step";
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
    annotation(Documentation(info="<html><p>Component <code>clock-offset</code>:</p><p><code>y(t) = u(t - d); d = initial + offset*t + jitter*n</code></p></html>"));
  end ClockOffset;

  block DacQuantisation "Resolution of the command's converter"
    extends Interfaces.CommandFilter;
    parameter Real resolution(unit="V", min = 0) "Step of the converter: range over 2^bits";
  equation
    y = resolution*Functions.round(u/resolution);
    annotation(Documentation(info="<html><p>Component <code>dac-quantisation</code>:</p><p><code>y = resolution*round(x/resolution)</code></p></html>"));
  end DacQuantisation;
end Timing;

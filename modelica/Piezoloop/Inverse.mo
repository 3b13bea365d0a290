within Piezoloop;
package Inverse "Feedforward: inverses of the hysteresis models"
  block InversePrandtlIshlinskii "Exact inverse of a Prandtl-Ishlinskii model, given by the forward model's parameters"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real inverse_r[plays](each unit="um") = Functions.inverseThresholds(r, w) "Thresholds of the inverse";
    final parameter Real inverse_w[plays](each unit="V/um") = Functions.inverseWeights(r, w) "Weights of the inverse";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="um") "Plays of the inverse";
  equation
    when sample(0, step) then
      p = Functions.plays(u_um - offset, inverse_r, 0, pre(p));
    end when;
    y = inverse_w*p;
    annotation(Documentation(info="<html><p>Component <code>inverse-prandtl-ishlinskii</code>:</p><p><code>u = sum(w'[i]*P[i]); P[i] = max(y - offset - r'[i], min(y - offset + r'[i], P[i])); w'[1] = 1/w[1]; w'[i] = -w[i]/(sum(w[1..i])*sum(w[1..i-1])); r'[i] = sum(w[j]*(r[i] - r[j]), j = 1..i)</code></p></html>"));
  end InversePrandtlIshlinskii;

  block InverseModifiedPrandtlIshlinskii "Exact inverse of a modified Prandtl-Ishlinskii model, given by its parameters"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Integer zones(min = 1, max = 256) "Number of one-sided dead zones";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real edge[zones](each unit="um") "Edge of each dead zone, increasing, not 0";
    parameter Real slope[zones](each unit="1") "Change of the slope beyond each edge, away from 0";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real inverse_r[plays](each unit="um") = Functions.inverseThresholds(r, w) "Thresholds of the inverse";
    final parameter Real inverse_w[plays](each unit="V/um") = Functions.inverseWeights(r, w) "Weights of the inverse";
    final parameter Real inverse_edge[zones](each unit="um") = Functions.inverseEdges(edge, slope) "Edges of the inverse map";
    final parameter Real inverse_slope[zones](each unit="1") = Functions.inverseSlopes(edge, slope) "Changes of its slope";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="um") "Plays of the inverse";
  equation
    when sample(0, step) then
      p = Functions.plays(Functions.deadZones(u_um - offset, inverse_edge, inverse_slope), inverse_r, 0, pre(p));
    end when;
    y = inverse_w*p;
    annotation(Documentation(info="<html><p>Component <code>inverse-modified-prandtl-ishlinskii</code>:</p><p><code>u = inverse plays of S^-1(y - offset); S^-1 is piecewise linear with the edges S(edge[j]) and the reciprocal slopes</code></p></html>"));
  end InverseModifiedPrandtlIshlinskii;

  block InverseGeneralisedPlay "Exact right inverse of a generalised-play model, given by its parameters"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real left_a0(unit="V", min = 0) "Rising envelope, height";
    parameter Real left_a1(unit="1/V", min = 0) "Rising envelope, steepness";
    parameter Real left_a2(unit="1") = 0 "Rising envelope, shift inside";
    parameter Real left_a3(unit="V") = 0 "Rising envelope, shift outside";
    parameter Real right_a0(unit="V", min = 0) "Falling envelope, height";
    parameter Real right_a1(unit="1/V", min = 0) "Falling envelope, steepness";
    parameter Real right_a2(unit="1") = 0 "Falling envelope, shift inside";
    parameter Real right_a3(unit="V") = 0 "Falling envelope, shift outside";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real virgin(unit="V") = max(left_a0*tanh(left_a2) + left_a3, min(right_a0*tanh(right_a2) + right_a3, 0))
      "Play between the envelopes that never moved, at command 0";
    final parameter Real inverse_r[plays](each unit="um") = Functions.inverseThresholds(r, w) "Thresholds of the inverse";
    final parameter Real inverse_w[plays](each unit="V/um") = Functions.inverseWeights(r, w) "Weights of the inverse";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="um") "Plays of the inverse";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real s(start = 0, fixed = true, unit="V") "Play between the envelopes";
    discrete Real held(start = 0, fixed = true, unit="V") "Command";
  equation
    when sample(0, step) then
      on = true;
      p = Functions.plays(u_um - offset, inverse_r, 0, pre(p));
      s = inverse_w*p;
      held = if s > (if pre(on) then pre(s) else virgin) then
          (Functions.atanh((s - left_a3)/left_a0) - left_a2)/left_a1
        elseif s < (if pre(on) then pre(s) else virgin) then
          (Functions.atanh((s - right_a3)/right_a0) - right_a2)/right_a1
        else pre(held);
    end when;
    y = held;
    annotation(Documentation(info="<html><p>Component <code>inverse-generalised-play</code>:</p><p><code>s = inverse plays of (y - offset); u = left^-1(s) while s rises, right^-1(s) while it falls</code></p></html>"));
  end InverseGeneralisedPlay;

  block InversePreisach "Inverse of a discrete Preisach model, by bisection over its levels"
    extends Interfaces.Inverse;
    parameter Integer relays(min = 1, max = 32896) "Number of relays, N*(N + 1)/2";
    parameter Real mu[relays](each unit="um", each min = 0) "Weight of each relay, row by row";
    parameter Real low(unit="V") "Command below which all relays are off";
    parameter Real high(unit="V") "Command from which on all relays are on";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real levels = (sqrt(8*relays + 1) - 1)/2 "Number of levels, N";
    discrete Real gamma[relays](each start = 0, each fixed = true) "Relays of the copy, row by row";
    discrete Real level(start = 0, fixed = true) "Level of the command";
  equation
    when sample(0, step) then
      level = Functions.nearestLevel(u_um - offset, pre(level), levels, mu, pre(gamma));
      gamma = Functions.relays(level, pre(gamma));
    end when;
    y = low + (level + 0.5)*(high - low)/levels;
    annotation(Documentation(info="<html><p>Component <code>inverse-preisach</code>:</p><p><code>|preisach(u) - y| is least; u = low + (level + 1/2)*(high - low)/N</code></p></html>"));
  end InversePreisach;

  block InverseBoucWen "Inverse of a Bouc-Wen model, solved at each step"
    extends Interfaces.Inverse;
    parameter Real gain(unit="um/V", min = 0) "Position per command without hysteresis";
    parameter Real alpha(unit="1", min = 0) "Share of the gain that the hysteresis takes after a reversal";
    parameter Real beta(unit="1/V", min = 0) "Decay of h that opposes it on both branches";
    parameter Real gamma(unit="1/V") "Decay of h that depends on the direction";
    parameter Real delta(unit="1/V") = 0 "Asymmetry between rising and falling branch";
    parameter Real exponent(unit="1", min = 1, max = 20) = 1 "Sharpness of the bend towards saturation";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real command_min(unit="V") "Least command that the inverse gives";
    parameter Real command_max(unit="V") "Greatest command that the inverse gives";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real command(start = 0, fixed = true, unit="V") "Command, solved at each sample";
    discrete Real h(start = 0, fixed = true, unit="um") "Hysteretic part of the copy";
  equation
    when sample(0, step) then
      command = Solve.boucWen(u_um, pre(command), pre(h), command_min, command_max, offset, gain, alpha, beta, gamma, delta, exponent);
      h = Functions.boucWen(pre(h), command - pre(command), alpha*gain, beta, gamma, delta, exponent);
    end when;
    y = command;
    annotation(Documentation(info="<html><p>Component <code>inverse-bouc-wen</code>:</p><p><code>offset + gain*u - h(u) = y</code></p></html>"));
  end InverseBoucWen;

  block InverseDuhem "Inverse of a Duhem model, solved at each step"
    extends Interfaces.Inverse;
    parameter Real slope(unit="um/V") "Slope of the centre line";
    parameter Real initial_(unit="um/V") "Slope right after a reversal";
    parameter Real decay(unit="1/V", min = 0) "How fast a branch joins the major loop";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real command_min(unit="V") "Least command that the inverse gives";
    parameter Real command_max(unit="V") "Greatest command that the inverse gives";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real command(start = 0, fixed = true, unit="V") "Command, solved at each sample";
    discrete Real e(start = 0, fixed = true, unit="um") "Distance of the copy from its centre line";
  equation
    when sample(0, step) then
      command = Solve.duhem(u_um, pre(command), pre(e), command_min, command_max, offset, slope, (slope - initial_)/decay, decay);
      e = Functions.duhem(pre(e), command - pre(command), (slope - initial_)/decay, decay);
    end when;
    y = command;
    annotation(Documentation(info="<html><p>Component <code>inverse-duhem</code>:</p><p><code>duhem(u) = y</code></p></html>"));
  end InverseDuhem;

  block InverseDahl "Inverse of a Dahl model, solved at each step"
    extends Interfaces.Inverse;
    parameter Real gain(unit="um/V") "Slope of the centre line";
    parameter Real height(unit="um", min = 0) "Half height of the major loop";
    parameter Real length(unit="V", min = 0) "Way in which a branch closes 63 % of its distance";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real command_min(unit="V") "Least command that the inverse gives";
    parameter Real command_max(unit="V") "Greatest command that the inverse gives";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real command(start = 0, fixed = true, unit="V") "Command, solved at each sample";
    discrete Real e(start = 0, fixed = true, unit="um") "Distance of the copy from its centre line";
  equation
    when sample(0, step) then
      command = Solve.duhem(u_um, pre(command), pre(e), command_min, command_max, offset, gain, height, 1/length);
      e = Functions.duhem(pre(e), command - pre(command), height, 1/length);
    end when;
    y = command;
    annotation(Documentation(info="<html><p>Component <code>inverse-dahl</code>:</p><p><code>dahl(u) = y</code></p></html>"));
  end InverseDahl;

  block InverseRateDependentPlay "Inverse of a rate-dependent-play model, solved at each step"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real gain(unit="um/V", min = 0) = 0 "Part of the elongation without memory";
    parameter Real rate(unit="s", min = 0) "Growth of every threshold with the command's rate";
    parameter Real command_min(unit="V") "Least command that the inverse gives";
    parameter Real command_max(unit="V") "Greatest command that the inverse gives";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real mean_slope(unit="um/V") = Functions.meanSlope(gain, r, w, command_max - command_min) "Mean slope of the largest loop";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real wanted(start = 0, fixed = true, unit="um") "Position at the last sample";
    discrete Real wanted_rate(start = 0, fixed = true, unit="um/s") "Rate of the position";
    discrete Real speed(start = 0, fixed = true, unit="V/s") "Rate of the command, by backward difference";
    discrete Real command(start = 0, fixed = true, unit="V") "Command, solved at each sample";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays of the copy";
  equation
    when sample(0, step) then
      on = true;
      wanted = u_um;
      wanted_rate = if pre(on) then (u_um - pre(wanted))/step else 0;
      command = Solve.cubicPlays(u_um, command_min, command_max, offset, gain, 0, r, w, rate*abs(wanted_rate/mean_slope), pre(p));
      speed = if pre(on) then (command - pre(command))/step else 0;
      p = Functions.plays(command, r, rate*abs(speed), pre(p));
    end when;
    y = command;
    annotation(Documentation(info="<html><p>Component <code>inverse-rate-dependent-play</code>:</p><p><code>forward(u) = y, with u' = y'/(mean slope of the largest loop)</code></p></html>"));
  end InverseRateDependentPlay;

  block InverseGrpi "Inverse of a grpi model, solved at each step"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real a1(unit="1", min = 0) = 1 "Slope of the rising envelope";
    parameter Real a2(unit="s") = 0 "Shift of the rising envelope with the rate";
    parameter Real b1(unit="1", min = 0) = 1 "Slope of the falling envelope";
    parameter Real b2(unit="s") = 0 "Shift of the falling envelope with the rate";
    parameter Real command_min(unit="V") "Least command that the inverse gives";
    parameter Real command_max(unit="V") "Greatest command that the inverse gives";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real mean_slope(unit="um/V") = Functions.meanSlope(0, r, w, command_max - command_min) "Mean slope of the largest loop";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real wanted(start = 0, fixed = true, unit="um") "Position at the last sample";
    discrete Real wanted_rate(start = 0, fixed = true, unit="um/s") "Rate of the position";
    discrete Real speed(start = 0, fixed = true, unit="V/s") "Rate of the command, by backward difference";
    discrete Real command(start = 0, fixed = true, unit="V") "Command, solved at each sample";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays of the copy";
  equation
    when sample(0, step) then
      on = true;
      wanted = u_um;
      wanted_rate = if pre(on) then (u_um - pre(wanted))/step else 0;
      command = Solve.envelopedPlays(u_um, command_min, command_max, offset, a1, a2*abs(wanted_rate/mean_slope), b1, b2*abs(wanted_rate/mean_slope), r, w, pre(p));
      speed = if pre(on) then (command - pre(command))/step else 0;
      p = Functions.envelopedPlays(a1*command + a2*abs(speed), b1*command + b2*abs(speed), r, pre(p));
    end when;
    y = command;
    annotation(Documentation(info="<html><p>Component <code>inverse-grpi</code>:</p><p><code>forward(u) = y, with u' = y'/(mean slope of the largest loop)</code></p></html>"));
  end InverseGrpi;

  block InverseMpi "Inverse of an mpi model, solved at each step"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real linear(unit="um/V") "Linear part without memory";
    parameter Real cubic(unit="um/(V.V.V)") = 0 "Cubic part without memory";
    parameter Real scale(unit="1", min = 0) = 1 "Factor of all thresholds";
    parameter Real rate(unit="s", min = 0) "Growth of every threshold with the command's rate";
    parameter Real command_min(unit="V") "Least command that the inverse gives";
    parameter Real command_max(unit="V") "Greatest command that the inverse gives";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real mean_slope(unit="um/V") = Functions.meanSlope(linear, scale*r, w, command_max - command_min) "Mean slope of the largest loop";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real wanted(start = 0, fixed = true, unit="um") "Position at the last sample";
    discrete Real wanted_rate(start = 0, fixed = true, unit="um/s") "Rate of the position";
    discrete Real speed(start = 0, fixed = true, unit="V/s") "Rate of the command, by backward difference";
    discrete Real command(start = 0, fixed = true, unit="V") "Command, solved at each sample";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays of the copy";
  equation
    when sample(0, step) then
      on = true;
      wanted = u_um;
      wanted_rate = if pre(on) then (u_um - pre(wanted))/step else 0;
      command = Solve.cubicPlays(u_um, command_min, command_max, offset, linear, cubic, scale*r, w, rate*abs(wanted_rate/mean_slope), pre(p));
      speed = if pre(on) then (command - pre(command))/step else 0;
      p = Functions.plays(command, scale*r, rate*abs(speed), pre(p));
    end when;
    y = command;
    annotation(Documentation(info="<html><p>Component <code>inverse-mpi</code>:</p><p><code>forward(u) = y, with u' = y'/(mean slope of the largest loop)</code></p></html>"));
  end InverseMpi;

  block InverseDynamicPrandtlIshlinskii "Inverse of a dynamic Prandtl-Ishlinskii model, solved at each step"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Integer segments(min = 4, max = 4) "Number of segments of the loop, four";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real alpha[segments](each unit="um.s/(V.V)") "Change of every weight with the command's rate, per segment";
    parameter Real beta[segments](each unit="um.s2/(V.V)") "Change of every weight with the command's acceleration, per segment";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real command_min(unit="V") "Least command that the inverse gives";
    parameter Real command_max(unit="V") "Greatest command that the inverse gives";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real mean_slope(unit="um/V") = Functions.meanSlope(0, r, w, command_max - command_min) "Mean slope of the largest loop";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real wanted(start = 0, fixed = true, unit="um") "Position at the last sample";
    discrete Real wanted_rate(start = 0, fixed = true, unit="um/s") "Rate of the position";
    discrete Real phi(start = 0, fixed = true, unit="um/V") "Change of every weight";
    discrete Real command(start = 0, fixed = true, unit="V") "Command, solved at each sample";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays of the copy";
  equation
    when sample(0, step) then
      on = true;
      wanted = u_um;
      wanted_rate = if pre(on) then (u_um - pre(wanted))/step else 0;
      phi = Functions.segmentWeight(wanted_rate/mean_slope,
        if pre(on) then (wanted_rate - pre(wanted_rate))/step/mean_slope else 0, alpha, beta);
      command = Solve.prandtlIshlinskii(u_um, command_min, command_max, offset, phi, r, w, pre(p));
      p = Functions.plays(command, r, 0, pre(p));
    end when;
    y = command;
    annotation(Documentation(info="<html><p>Component <code>inverse-dynamic-prandtl-ishlinskii</code>:</p><p><code>forward(u) = y, with u' = y'/(mean slope of the largest loop) and u'' alike</code></p></html>"));
  end InverseDynamicPrandtlIshlinskii;

  block InverseKelvinVoigtCreep "Takes the creep of Kelvin-Voigt elements out of a reference"
    extends Interfaces.ReferenceFilter;
    parameter Integer elements(min = 1, max = 64) "Number of elements";
    parameter Real share[elements](each unit="1") "Part of a step that each element adds in the end";
    parameter Real time_constant[elements](each unit="s", each min = 0) "Time constant of each element, increasing";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real fraction[elements](each unit="1") = {1 - exp(-step/time_constant[i]) for i in 1:elements}
      "Part of its way that an element goes in a step";
    final parameter Real left[elements](each unit="1") = {share[i]*exp(-step/time_constant[i]) for i in 1:elements}
      "What an element still adds after a step";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real z[elements](each start = 0, each fixed = true, each unit="um") "Elements";
    discrete Real v(start = 0, fixed = true, unit="um") "Position without the creep";
  equation
    when sample(0, step) then
      on = true;
      v = if pre(on) then (u_um - left*pre(z))/(1 + share*fraction) else u_um/(1 + sum(share));
      z = Functions.lags(v, if pre(on) then 1 else 0, fraction, pre(z));
    end when;
    y_um = v;
    annotation(Documentation(info="<html><p>Component <code>inverse-kelvin-voigt-creep</code>:</p><p><code>u + sum(share[i]*z[i]) = y; time_constant[i]*z[i]' = u - z[i]</code></p></html>"));
  end InverseKelvinVoigtCreep;
end Inverse;

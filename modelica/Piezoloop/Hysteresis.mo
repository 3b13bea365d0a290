within Piezoloop;
package Hysteresis "Memory of the actuator, one step per sample"
  block PrandtlIshlinskii "Symmetric hysteresis, independent of rate: a weighted sum of play operators"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      p = Functions.plays(u, r, 0, pre(p));
    end when;
    y_um = offset + w*p;
    annotation(Documentation(info="<html><p>Component <code>prandtl-ishlinskii</code>:</p><p><code>y = offset + sum(w[i]*P[i]); P[i] = max(u - r[i], min(u + r[i], P[i]))</code></p></html>"));
  end PrandtlIshlinskii;

  block ModifiedPrandtlIshlinskii "Asymmetric hysteresis, independent of rate: plays followed by one-sided dead zones"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Integer zones(min = 1, max = 256) "Number of one-sided dead zones";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real edge[zones](each unit="um") "Edge of each dead zone, increasing, not 0";
    parameter Real slope[zones](each unit="1") "Change of the slope beyond each edge, away from 0";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      p = Functions.plays(u, r, 0, pre(p));
    end when;
    y_um = offset + Functions.deadZones(w*p, edge, slope);
    annotation(Documentation(info="<html><p>Component <code>modified-prandtl-ishlinskii</code>:</p><p><code>y = offset + x + sum(slope[j]*z[j](x)); x = sum(w[i]*P[i]); z[j] = max(x - edge[j], 0) for edge[j] &gt; 0, else min(x - edge[j], 0)</code></p></html>"));
  end ModifiedPrandtlIshlinskii;

  block SkewedPlay "Asymmetric hysteresis, independent of rate: plays that are wider at one end of the range"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real skew[plays](each unit="um/V") "Growth of the weight of each play's memory to the upper end of the range";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real play_weight(unit="um/V") = 0 "Weight of the play whose width changes";
    parameter Real width(unit="1", min = 0) = 0 "Half width of that play at the centre over half_range";
    parameter Real width_growth(unit="1") = 0 "Growth of the width to the upper end of the range";
    parameter Real width_curvature(unit="1") = 0 "Growth of the width to both ends of the range";
    parameter Real centre(unit="V") "Middle of the range";
    parameter Real half_range(unit="V", min = 0) "Half of the range";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real x(start = 0, fixed = true) "Place in the range, from -1 to 1";
    discrete Real q[1](each start = 0, each fixed = true, each unit="V") "The play whose width changes";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      last = u;
      x = (u - centre)/half_range;
      p = Functions.plays(u, r, 0, pre(p));
      q = Functions.plays(u, {half_range*max(0, width + x*(width_growth + x*width_curvature))}, 0, pre(q));
    end when;
    y_um = offset + w*p + x*(skew*p - last*sum(skew)) + play_weight*(q[1] - last);
    annotation(Documentation(info="<html><p>Component <code>skewed-play</code>:</p><p><code>y = offset + sum(w[i]*P[i]) + x*sum(skew[i]*(P[i] - u)) + play_weight*(Q - u); P[i] = max(u - r[i], min(u + r[i], P[i])); Q the same with half_range*max(0, width + width_growth*x + width_curvature*x^2); x = (u - centre)/half_range</code></p></html>"));
  end SkewedPlay;

  block GeneralisedPlay "Asymmetric, saturating hysteresis: plays between hyperbolic-tangent envelopes"
    extends Interfaces.Actuator;
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
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real s(start = 0, fixed = true, unit="V") "Play between the envelopes";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      on = true;
      s = max(left_a0*tanh(left_a1*u + left_a2) + left_a3,
        min(right_a0*tanh(right_a1*u + right_a2) + right_a3, if pre(on) then pre(s) else virgin));
      p = Functions.plays(s, r, 0, pre(p));
    end when;
    y_um = offset + w*p;
    annotation(Documentation(info="<html><p>Component <code>generalised-play</code>:</p><p><code>y = offset + sum(w[i]*F[i]); F[i] = max(left(u) - r[i], min(right(u) + r[i], F[i])); left(u) = a0*tanh(a1*u + a2) + a3</code></p></html>"));
  end GeneralisedPlay;

  block Preisach "Discrete Preisach hysteresis: weighted relays, in constant time per step"
    extends Interfaces.Actuator;
    parameter Integer relays(min = 1, max = 32896) "Number of relays, N*(N + 1)/2";
    parameter Real mu[relays](each unit="um", each min = 0) "Weight of each relay, row by row";
    parameter Real low(unit="V") "Command below which all relays are off";
    parameter Real high(unit="V") "Command from which on all relays are on";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real levels = (sqrt(8*relays + 1) - 1)/2 "Number of levels, N";
    discrete Real gamma[relays](each start = 0, each fixed = true) "Relays, row by row: 1 is on";
    discrete Real level(start = 0, fixed = true) "Level that the command has reached";
  equation
    when sample(0, step) then
      level = max(0, min(levels, floor((u - low)*levels/(high - low))));
      gamma = Functions.relays(level, pre(gamma));
    end when;
    y_um = offset + mu*gamma;
    annotation(Documentation(info="<html><p>Component <code>preisach</code>:</p><p><code>y = offset + sum(mu[i,j]*relay[i,j]), j &lt;= i; a relay is on once u &gt;= t[i] and off once u &lt; t[j]; t[k] = low + k*(high - low)/N</code></p></html>"));
  end Preisach;

  block BoucWen "Bouc-Wen hysteresis, symmetric or asymmetric, exact over each step"
    extends Interfaces.Actuator;
    parameter Real gain(unit="um/V", min = 0) "Position per command without hysteresis";
    parameter Real alpha(unit="1", min = 0) "Share of the gain that the hysteresis takes after a reversal";
    parameter Real beta(unit="1/V", min = 0) "Decay of h that opposes it on both branches";
    parameter Real gamma(unit="1/V") "Decay of h that depends on the direction";
    parameter Real delta(unit="1/V") = 0 "Asymmetry between rising and falling branch";
    parameter Real exponent(unit="1", min = 1, max = 20) = 1 "Sharpness of the bend towards saturation";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real h(start = 0, fixed = true, unit="um") "Hysteretic part";
  equation
    when sample(0, step) then
      last = u;
      h = Functions.boucWen(pre(h), u - pre(last), alpha*gain, beta, gamma, delta, exponent);
    end when;
    y_um = offset + gain*last - h;
    annotation(Documentation(info="<html><p>Component <code>bouc-wen</code>:</p><p><code>y = offset + gain*u - h; dh/du = alpha*gain - (gamma + beta*sgn(u'*h) + delta*sgn(u'))*|h|*|h/hs|^(exponent - 1); hs = alpha*gain/(beta + gamma)</code></p></html>"));
  end BoucWen;

  block Duhem "Duhem hysteresis (Coleman-Hodgdon) with a straight centre line, exact over each step"
    extends Interfaces.Actuator;
    parameter Real slope(unit="um/V") "Slope of the centre line";
    parameter Real initial_(unit="um/V") "Slope right after a reversal";
    parameter Real decay(unit="1/V", min = 0) "How fast a branch joins the major loop";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real e(start = 0, fixed = true, unit="um") "Distance from the centre line";
  equation
    when sample(0, step) then
      last = u;
      e = Functions.duhem(pre(e), u - pre(last), (slope - initial_)/decay, decay);
    end when;
    y_um = offset + slope*last + e;
    annotation(Documentation(info="<html><p>Component <code>duhem</code>:</p><p><code>y' = decay*|u'|*(offset + slope*u - y) + initial*u'</code></p></html>"));
  end Duhem;

  block Dahl "Dahl hysteresis: a spring that yields, exact over each step"
    extends Interfaces.Actuator;
    parameter Real gain(unit="um/V") "Slope of the centre line";
    parameter Real height(unit="um", min = 0) "Half height of the major loop";
    parameter Real length(unit="V", min = 0) "Way in which a branch closes 63 % of its distance";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real e(start = 0, fixed = true, unit="um") "Distance from the centre line";
  equation
    when sample(0, step) then
      last = u;
      e = Functions.duhem(pre(e), u - pre(last), height, 1/length);
    end when;
    y_um = offset + gain*last + e;
    annotation(Documentation(info="<html><p>Component <code>dahl</code>:</p><p><code>y = offset + gain*u - h; dh/du = height/length*(1 - sgn(u')*h/height)</code></p></html>"));
  end Dahl;

  block RateDependentPlay "Hysteresis that widens with the rate: plays with rate-dependent thresholds"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real gain(unit="um/V", min = 0) = 0 "Part of the elongation without memory";
    parameter Real rate(unit="s", min = 0) "Growth of every threshold with the command's rate";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real speed(start = 0, fixed = true, unit="V/s") "Rate of the command, by backward difference";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      on = true;
      last = u;
      speed = if pre(on) then (u - pre(last))/step else 0;
      p = Functions.plays(u, r, rate*abs(speed), pre(p));
    end when;
    y_um = offset + gain*last + w*p;
    annotation(Documentation(info="<html><p>Component <code>rate-dependent-play</code>:</p><p><code>y = offset + gain*u + sum(w[i]*F[i]); F[i] = max(u - t[i], min(u + t[i], F[i])); t[i] = r[i] + rate*|u'|</code></p></html>"));
  end RateDependentPlay;

  block LaggingPlay "Hysteresis whose memory lags behind the command"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real gain(unit="um/V", min = 0) = 0 "Part of the elongation without memory";
    parameter Real bandwidth(unit="Hz", min = 0) "Frequency from which on the memory lags";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real v(start = 0, fixed = true, unit="V") "What the memory has seen of the command";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      on = true;
      last = u;
      v = if pre(on) then pre(v) + (1 - exp(-2*Constants.pi*bandwidth*step))*(u - pre(v)) else u;
      p = Functions.plays(v, r, 0, pre(p));
    end when;
    y_um = offset + gain*last + w*p;
    annotation(Documentation(info="<html><p>Component <code>lagging-play</code>:</p><p><code>y = offset + gain*u + sum(w[i]*P[i]); P[i] = max(v - r[i], min(v + r[i], P[i])); v' = 2*pi*bandwidth*(u - v)</code></p></html>"));
  end LaggingPlay;

  block Grpi "Generalised rate-dependent Prandtl-Ishlinskii hysteresis"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real a1(unit="1", min = 0) = 1 "Slope of the rising envelope";
    parameter Real a2(unit="s") = 0 "Shift of the rising envelope with the rate";
    parameter Real b1(unit="1", min = 0) = 1 "Slope of the falling envelope";
    parameter Real b2(unit="s") = 0 "Shift of the falling envelope with the rate";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real speed(start = 0, fixed = true, unit="V/s") "Rate of the command, by backward difference";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      on = true;
      last = u;
      speed = if pre(on) then (u - pre(last))/step else 0;
      p = Functions.envelopedPlays(a1*u + a2*abs(speed), b1*u + b2*abs(speed), r, pre(p));
    end when;
    y_um = offset + w*p;
    annotation(Documentation(info="<html><p>Component <code>grpi</code>:</p><p><code>y = offset + sum(w[i]*P[i]); P[i] = max(hl - r[i], min(hr + r[i], P[i])); hl = a1*u + a2*|u'|; hr = b1*u + b2*|u'|</code></p></html>"));
  end Grpi;

  block Mpi "Modified rate-dependent Prandtl-Ishlinskii hysteresis: plays and a cubic polynomial"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real linear(unit="um/V") "Linear part without memory";
    parameter Real cubic(unit="um/(V.V.V)") = 0 "Cubic part without memory";
    parameter Real scale(unit="1", min = 0) = 1 "Factor of all thresholds";
    parameter Real rate(unit="s", min = 0) "Growth of every threshold with the command's rate";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real speed(start = 0, fixed = true, unit="V/s") "Rate of the command, by backward difference";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      on = true;
      last = u;
      speed = if pre(on) then (u - pre(last))/step else 0;
      p = Functions.plays(u, scale*r, rate*abs(speed), pre(p));
    end when;
    y_um = offset + linear*last + cubic*last^3 + w*p;
    annotation(Documentation(info="<html><p>Component <code>mpi</code>:</p><p><code>y = offset + linear*u + cubic*u^3 + sum(w[i]*F[i]); F[i] = max(u - t[i], min(u + t[i], F[i])); t[i] = scale*r[i] + rate*|u'|</code></p></html>"));
  end Mpi;

  block DynamicPrandtlIshlinskii "Prandtl-Ishlinskii hysteresis whose weights follow the command's rate in segments"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Integer segments(min = 4, max = 4) "Number of segments of the loop, four";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real alpha[segments](each unit="um.s/(V.V)") "Change of every weight with the command's rate, per segment";
    parameter Real beta[segments](each unit="um.s2/(V.V)") "Change of every weight with the command's acceleration, per segment";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real speed(start = 0, fixed = true, unit="V/s") "Rate of the command, by backward difference";
    discrete Real acceleration(start = 0, fixed = true, unit="V/s2") "Second difference of the command";
    discrete Real phi(start = 0, fixed = true, unit="um/V") "Change of every weight";
    discrete Real p[plays](each start = 0, each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      on = true;
      last = u;
      speed = if pre(on) then (u - pre(last))/step else 0;
      acceleration = if pre(on) then (speed - pre(speed))/step else 0;
      phi = Functions.segmentWeight(speed, acceleration, alpha, beta);
      p = Functions.plays(u, r, 0, pre(p));
    end when;
    y_um = offset + w*p + phi*sum(p);
    annotation(Documentation(info="<html><p>Component <code>dynamic-prandtl-ishlinskii</code>:</p><p><code>y = offset + sum((w[i] + phi)*P[i]); phi = alpha[s]*u' + beta[s]*u''; segment s by the signs of u' and u''</code></p></html>"));
  end DynamicPrandtlIshlinskii;
end Hysteresis;

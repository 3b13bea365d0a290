within Piezoloop;
package Inverse "Feedforward: inverses of the hysteresis models"
  extends Icons.Package;
  block InversePrandtlIshlinskii "Exact inverse of a Prandtl-Ishlinskii model, given by the forward model's parameters"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V") "Weight of each play; the first k add up to 0 or more";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-63},{-73,-45},{-37,-11},{80,70},{73,52},{46,24},{6,-10},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-prandtl-ishlinskii</code>. Exact inverse of a Prandtl-Ishlinskii model, given by the forward model's parameters.</p><p><code>u = sum(w'[i]*P[i]); P[i] = max(y - offset - r'[i], min(y - offset + r'[i], P[i])); w'[1] = 1/w[1]; w'[i] = -w[i]/(sum(w[1..i])*sum(w[1..i-1])); r'[i] = sum(w[j]*(r[i] - r[j]), j = 1..i)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Weight of each play; the first k add up to 0 or more</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: K. Kuhnen, European Journal of Control 9 (2003) 407-418.</p></html>"));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-63},{-73,-44},{-14,11},{80,70},{72,51},{43,24},{-14,-19},{-40,-42},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-modified-prandtl-ishlinskii</code>. Exact inverse of a modified Prandtl-Ishlinskii model, given by its parameters.</p><p><code>u = inverse plays of S^-1(y - offset); S^-1 is piecewise linear with the edges S(edge[j]) and the reciprocal slopes</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>zones` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>256</td><td>Number of one-sided dead zones</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>edge</td><td>{position}</td><td>required</td><td></td><td></td><td>Edge of each dead zone, increasing, not 0</td></tr><tr><td>slope</td><td>1</td><td>required</td><td></td><td></td><td>Change of the slope beyond each edge, away from 0</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: K. Kuhnen, European Journal of Control 9 (2003) 407-418.</p></html>"));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-69},{-73,-65},{8,-56},{80,70},{80,63},{78,63},{78,-36},{73,-51},{55,-56},{29,-61},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-generalised-play</code>. Exact right inverse of a generalised-play model, given by its parameters.</p><p><code>s = inverse plays of (y - offset); u = left^-1(s) while s rises, right^-1(s) while it falls</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>left_a0</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Rising envelope, height</td></tr><tr><td>left_a1</td><td>1/{command}</td><td>required</td><td>0</td><td></td><td>Rising envelope, steepness</td></tr><tr><td>left_a2</td><td>1</td><td>0</td><td></td><td></td><td>Rising envelope, shift inside</td></tr><tr><td>left_a3</td><td>{command}</td><td>0</td><td></td><td></td><td>Rising envelope, shift outside</td></tr><tr><td>right_a0</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Falling envelope, height</td></tr><tr><td>right_a1</td><td>1/{command}</td><td>required</td><td>0</td><td></td><td>Falling envelope, steepness</td></tr><tr><td>right_a2</td><td>1</td><td>0</td><td></td><td></td><td>Falling envelope, shift inside</td></tr><tr><td>right_a3</td><td>{command}</td><td>0</td><td></td><td></td><td>Falling envelope, shift outside</td></tr></table><p>Source: M. Al Janaideh, S. Rakheja, C.-Y. Su, IEEE/ASME Trans. Mechatronics 16 (2011) 734-744.</p></html>"));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-78,-70},{-77,-52},{-76,-52},{-76,-35},{-75,-52},{-75,-35},{-72,-35},{-72,-18},{-72,-35},{-71,-18},{-68,-18},{-67,0},{-67,-18},{-65,0},{-61,0},{-61,18},{-59,0},{-58,18},{-55,18},{-54,35},{-53,0},{-52,35},{-51,18},{-50,35},{-46,35},{-45,52},{-44,18},{-42,52},{-36,52},{-35,70},{-35,35},{-31,70},{80,70},{-31,70},{-34,35},{-36,35},{-37,18},{-41,18},{-42,0},{-43,18},{-44,0},{-47,0},{-48,-18},{-49,0},{-50,-18},{-54,-18},{-55,-35},{-56,0},{-57,-35},{-64,-35},{-65,-52},{-66,-18},{-69,-52},{-69,-35},{-70,-52},{-74,-52},{-74,-70},{-75,-35},{-77,-70},{-77,-52},{-78,-70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-preisach</code>. Inverse of a discrete Preisach model, by bisection over its levels.</p><p><code>|preisach(u) - y| is least; u = low + (level + 1/2)*(high - low)/N</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>relays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>32896</td><td>Number of relays, N*(N + 1)/2</td></tr><tr><td>mu</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Weight of each relay, row by row</td></tr><tr><td>low</td><td>{command}</td><td>required</td><td></td><td></td><td>Command below which all relays are off</td></tr><tr><td>high</td><td>{command}</td><td>required</td><td></td><td></td><td>Command from which on all relays are on</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: R. V. Iyer, X. Tan, P. S. Krishnaprasad, IEEE Trans. Automatic Control 50 (2005) 798-810.</p></html>"));
  end InversePreisach;

  block InverseBoucWen "Inverse of a Bouc-Wen model, solved at each step"
    extends Interfaces.Inverse;
    parameter Real gain(unit="um/V", min = 0) "Position per command without hysteresis";
    parameter Real alpha(unit="1", min = 0) "Share of the gain that the hysteresis removes after a reversal";
    parameter Real beta(unit="1/V", min = 0) "Decay of h towards zero on both branches";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-70,-80},{-33,-33},{70,80},{49,46},{30,20},{-61,-80}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-bouc-wen</code>. Inverse of a Bouc-Wen model, solved at each step.</p><p><code>offset + gain*u - h(u) = y</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Position per command without hysteresis</td></tr><tr><td>alpha</td><td>1</td><td>required</td><td>0</td><td></td><td>Share of the gain that the hysteresis removes after a reversal</td></tr><tr><td>beta</td><td>1/{command}</td><td>required</td><td>0</td><td></td><td>Decay of h towards zero on both branches</td></tr><tr><td>gamma</td><td>1/{command}</td><td>required</td><td></td><td></td><td>Decay of h that depends on the direction</td></tr><tr><td>delta</td><td>1/{command}</td><td>0</td><td></td><td></td><td>Asymmetry between rising and falling branch</td></tr><tr><td>exponent</td><td>1</td><td>1</td><td>1</td><td>20</td><td>Sharpness of the bend towards saturation</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>command_min</td><td>{command}</td><td>required</td><td></td><td></td><td>Least command that the inverse gives</td></tr><tr><td>command_max</td><td>{command}</td><td>required</td><td></td><td></td><td>Greatest command that the inverse gives</td></tr></table><p>Source: M. Rakotondrabe, IEEE Trans. Automation Science and Engineering 8 (2011) 428-431.</p></html>"));
  end InverseBoucWen;

  block InverseDuhem "Inverse of a Duhem model, solved at each step"
    extends Interfaces.Inverse;
    parameter Real slope(unit="um/V") "Slope of the centre line";
    parameter Real initial_(unit="um/V") "Slope right after a reversal";
    parameter Real decay(unit="1/V", min = 0) "Rate at which a branch approaches the major loop, per unit of command";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-70,-80},{-24,-22},{70,80},{57,54},{34,22},{-57,-80}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-duhem</code>. Inverse of a Duhem model, solved at each step.</p><p><code>duhem(u) = y</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>slope</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Slope of the centre line</td></tr><tr><td>initial</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Slope right after a reversal</td></tr><tr><td>decay</td><td>1/{command}</td><td>required</td><td>0</td><td></td><td>Rate at which a branch approaches the major loop, per unit of command</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>command_min</td><td>{command}</td><td>required</td><td></td><td></td><td>Least command that the inverse gives</td></tr><tr><td>command_max</td><td>{command}</td><td>required</td><td></td><td></td><td>Greatest command that the inverse gives</td></tr></table><p>Source: B. D. Coleman, M. L. Hodgdon, Int. J. Eng. Sci. 24 (1986) 897-919 (the model).</p></html>"));
  end InverseDuhem;

  block InverseDahl "Inverse of a Dahl model, solved at each step"
    extends Interfaces.Inverse;
    parameter Real gain(unit="um/V") "Slope of the centre line";
    parameter Real height(unit="um", min = 0) "Half height of the major loop";
    parameter Real length(unit="V", min = 0) "Change of the command over which a branch covers 63 % of its distance to the major loop";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-70,-80},{-29,-26},{70,80},{60,57},{38,26},{-58,-80}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-dahl</code>. Inverse of a Dahl model, solved at each step.</p><p><code>dahl(u) = y</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Slope of the centre line</td></tr><tr><td>height</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Half height of the major loop</td></tr><tr><td>length</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Change of the command over which a branch covers 63 % of its distance to the major loop</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>command_min</td><td>{command}</td><td>required</td><td></td><td></td><td>Least command that the inverse gives</td></tr><tr><td>command_max</td><td>{command}</td><td>required</td><td></td><td></td><td>Greatest command that the inverse gives</td></tr></table><p>Source: P. R. Dahl, Aerospace Corp. TOR-0158(3107-18)-1, 1968 (the model).</p></html>"));
  end InverseDahl;

  block InverseRateDependentPlay "Inverse of a rate-dependent-play model, solved at each step"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real gain(unit="um/V", min = 0) = 0 "Linear part without hysteresis";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-70,-80},{-64,-65},{-48,-43},{-26,-17},{-1,8},{14,80},{70,80},{58,50},{27,6},{-17,-46},{-52,-80}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-rate-dependent-play</code>. Inverse of a rate-dependent-play model, solved at each step.</p><p><code>forward(u) = y, with u' = y'/(mean slope of the largest loop)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>gain</td><td>{position}/{command}</td><td>0</td><td>0</td><td></td><td>Linear part without hysteresis</td></tr><tr><td>rate</td><td>s</td><td>required</td><td>0</td><td></td><td>Growth of every threshold with the command's rate</td></tr><tr><td>command_min</td><td>{command}</td><td>required</td><td></td><td></td><td>Least command that the inverse gives</td></tr><tr><td>command_max</td><td>{command}</td><td>required</td><td></td><td></td><td>Greatest command that the inverse gives</td></tr></table><p>Source: M. Al Janaideh, P. Krejci, IEEE/ASME Trans. Mechatronics 18 (2013) 1498-1507.</p></html>"));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-70,-80},{-66,-66},{-52,-44},{-31,-19},{-3,8},{-2,80},{70,80},{64,57},{34,13},{-8,-42},{-47,-80}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-grpi</code>. Inverse of a grpi model, solved at each step.</p><p><code>forward(u) = y, with u' = y'/(mean slope of the largest loop)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>a1</td><td>1</td><td>1</td><td>0</td><td></td><td>Slope of the rising envelope</td></tr><tr><td>a2</td><td>s</td><td>0</td><td></td><td></td><td>Shift of the rising envelope with the rate</td></tr><tr><td>b1</td><td>1</td><td>1</td><td>0</td><td></td><td>Slope of the falling envelope</td></tr><tr><td>b2</td><td>s</td><td>0</td><td></td><td></td><td>Shift of the falling envelope with the rate</td></tr><tr><td>command_min</td><td>{command}</td><td>required</td><td></td><td></td><td>Least command that the inverse gives</td></tr><tr><td>command_max</td><td>{command}</td><td>required</td><td></td><td></td><td>Greatest command that the inverse gives</td></tr></table><p>Source: C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated Elliptical Vibration Cutting Device, eq. (13).</p></html>"));
  end InverseGrpi;

  block InverseMpi "Inverse of an mpi model, solved at each step"
    extends Interfaces.Inverse;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real linear(unit="um/V") "Linear part without hysteresis";
    parameter Real cubic(unit="um/(V.V.V)") = 0 "Cubic part without hysteresis";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-70,-80},{-62,-64},{-45,-40},{-1,8},{20,80},{70,80},{55,48},{20,1},{-30,-57},{-52,-80}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-mpi</code>. Inverse of an mpi model, solved at each step.</p><p><code>forward(u) = y, with u' = y'/(mean slope of the largest loop)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>linear</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Linear part without hysteresis</td></tr><tr><td>cubic</td><td>{position}/{command}/{command}/{command}</td><td>0</td><td></td><td></td><td>Cubic part without hysteresis</td></tr><tr><td>scale</td><td>1</td><td>1</td><td>0</td><td></td><td>Factor of all thresholds</td></tr><tr><td>rate</td><td>s</td><td>required</td><td>0</td><td></td><td>Growth of every threshold with the command's rate</td></tr><tr><td>command_min</td><td>{command}</td><td>required</td><td></td><td></td><td>Least command that the inverse gives</td></tr><tr><td>command_max</td><td>{command}</td><td>required</td><td></td><td></td><td>Greatest command that the inverse gives</td></tr></table><p>Source: M. Al Janaideh, P. Krejci, IEEE/ASME Trans. Mechatronics 18 (2013) 1498-1507.</p></html>"));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-70,-80},{-68,-66},{-59,-44},{-29,8},{70,80},{-2,80},{16,80},{11,51},{-12,-1},{-33,-44},{-56,-80}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-dynamic-prandtl-ishlinskii</code>. Inverse of a dynamic Prandtl-Ishlinskii model, solved at each step.</p><p><code>forward(u) = y, with u' = y'/(mean slope of the largest loop) and u'' alike</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>segments` (structure)</td><td>1</td><td>by its lists</td><td>4</td><td>4</td><td>Number of segments of the loop, four</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>alpha</td><td>{position}.s/{command}/{command}</td><td>required</td><td></td><td></td><td>Change of every weight with the command's rate, per segment</td></tr><tr><td>beta</td><td>{position}.s2/{command}/{command}</td><td>required</td><td></td><td></td><td>Change of every weight with the command's acceleration, per segment</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>command_min</td><td>{command}</td><td>required</td><td></td><td></td><td>Least command that the inverse gives</td></tr><tr><td>command_max</td><td>{command}</td><td>required</td><td></td><td></td><td>Greatest command that the inverse gives</td></tr></table><p>Source: C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated Elliptical Vibration Cutting Device, eqs. (14)-(17).</p></html>"));
  end InverseDynamicPrandtlIshlinskii;

  block InverseKelvinVoigtCreep "Inverse of Kelvin-Voigt creep: removes it from the reference"
    extends Interfaces.ReferenceFilter;
    parameter Integer elements(min = 1, max = 64) "Number of elements";
    parameter Real share[elements](each unit="1") "Final creep of each element, relative to the step";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-68},{80,70},{36,28},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>inverse-kelvin-voigt-creep</code>. Inverse of Kelvin-Voigt creep: removes it from the reference.</p><p><code>u + sum(share[i]*z[i]) = y; time_constant[i]*z[i]' = u - z[i]</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>elements` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of elements</td></tr><tr><td>share</td><td>1</td><td>required</td><td></td><td></td><td>Final creep of each element, relative to the step</td></tr><tr><td>time_constant</td><td>s</td><td>required</td><td>0</td><td></td><td>Time constant of each element, increasing</td></tr></table><p>Source: H. Janocha, K. Kuhnen, Sensors and Actuators A 79 (2000) 83-89.</p></html>"));
  end InverseKelvinVoigtCreep;
  annotation(Documentation(info="<html><p>Feedforward: inverses of the hysteresis models.</p></html>"));
end Inverse;

within Piezoloop;
package Hysteresis "Memory of the actuator, one step per sample"
  extends Icons.Package;
  block PrandtlIshlinskii "Symmetric hysteresis, independent of rate: a weighted sum of play operators"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V") "Weight of each play; the first k add up to 0 or more";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real u_start(unit="V") = 0 "Command under which the block rests before the start";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real p[plays](start = Functions.plays(u_start, r, 0, zeros(plays)), each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      p = Functions.plays(u, r, 0, pre(p));
    end when;
    y_um = offset + w*p;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-66,-66},{-18,-30},{80,70},{51,62},{9,33},{-44,-10},{-80,-47}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>prandtl-ishlinskii</code>. Symmetric hysteresis, independent of rate: a weighted sum of play operators.</p><p><code>y = offset + sum(w[i]*P[i]); P[i] = max(u - r[i], min(u + r[i], P[i]))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Weight of each play; the first k add up to 0 or more</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: K. Kuhnen, European Journal of Control 9 (2003) 407-418.</p><p>Compensated in front of the machine by inverse-prandtl-ishlinskii (closed form).</p><p>Effect: <code>hysteresis</code>.</p><p>In the residual: odd harmonics; width of the loop proportional to the amplitude, independent of rate.</p><p>Looks like: <code>backlash</code>, <code>creep</code>, <code>amplifier_bandwidth</code>.</p><p>Distinguished by: loops at two amplitudes and two rates: backlash keeps a constant width, a lag's width grows with the rate.</p></html>"));
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
    parameter Real u_start(unit="V") = 0 "Command under which the block rests before the start";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real p[plays](start = Functions.plays(u_start, r, 0, zeros(plays)), each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      p = Functions.plays(u, r, 0, pre(p));
    end when;
    y_um = offset + Functions.deadZones(w*p, edge, slope);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-66,-66},{-45,-52},{8,-9},{80,70},{51,61},{9,29},{-28,-4},{-67,-33},{-80,-47}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>modified-prandtl-ishlinskii</code>. Asymmetric hysteresis, independent of rate: plays followed by one-sided dead zones.</p><p><code>y = offset + x + sum(slope[j]*z[j](x)); x = sum(w[i]*P[i]); z[j] = max(x - edge[j], 0) for edge[j] &gt; 0, else min(x - edge[j], 0)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>zones` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>256</td><td>Number of one-sided dead zones</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>edge</td><td>{position}</td><td>required</td><td></td><td></td><td>Edge of each dead zone, increasing, not 0</td></tr><tr><td>slope</td><td>1</td><td>required</td><td></td><td></td><td>Change of the slope beyond each edge, away from 0</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: K. Kuhnen, European Journal of Control 9 (2003) 407-418.</p><p>Compensated in front of the machine by inverse-modified-prandtl-ishlinskii (closed form).</p><p>Effect: <code>asymmetry</code>.</p><p>In the residual: even harmonics; opposite sign on the rising and the falling branch.</p><p>Looks like: <code>sensor_nonlinearity</code>, <code>amplifier_saturation</code>.</p><p>Distinguished by: slow triangle: the residual over the command, rising and falling apart.</p></html>"));
  end ModifiedPrandtlIshlinskii;

  block SkewedPlay "Asymmetric hysteresis, independent of rate: plays that are wider at one end of the range"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real skew[plays](each unit="um/V") "Growth of the weight of each play's memory towards the upper end of the range";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real play_weight(unit="um/V") = 0 "Weight of the play whose width changes";
    parameter Real width(unit="1", min = 0) = 0 "Half width of that play at the centre, relative to half_range";
    parameter Real width_growth(unit="1") = 0 "Growth of the width towards the upper end of the range";
    parameter Real width_curvature(unit="1") = 0 "Growth of the width towards both ends of the range";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-66,-67},{-44,-53},{-18,-31},{80,70},{51,67},{10,40},{-44,-7},{-80,-46}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>skewed-play</code>. Asymmetric hysteresis, independent of rate: plays that are wider at one end of the range.</p><p><code>y = offset + sum(w[i]*P[i]) + x*sum(skew[i]*(P[i] - u)) + play_weight*(Q - u); P[i] = max(u - r[i], min(u + r[i], P[i])); Q the same with half_range*max(0, width + width_growth*x + width_curvature*x^2); x = (u - centre)/half_range</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>skew</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Growth of the weight of each play's memory towards the upper end of the range</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>play_weight</td><td>{position}/{command}</td><td>0</td><td></td><td></td><td>Weight of the play whose width changes</td></tr><tr><td>width</td><td>1</td><td>0</td><td>0</td><td></td><td>Half width of that play at the centre, relative to half_range</td></tr><tr><td>width_growth</td><td>1</td><td>0</td><td></td><td></td><td>Growth of the width towards the upper end of the range</td></tr><tr><td>width_curvature</td><td>1</td><td>0</td><td></td><td></td><td>Growth of the width towards both ends of the range</td></tr><tr><td>centre</td><td>{command}</td><td>required</td><td></td><td></td><td>Middle of the range</td></tr><tr><td>half_range</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Half of the range</td></tr></table><p>Source: A. Visintin, Differential Models of Hysteresis, Springer 1994, ch. III.</p><p>Effect: <code>asymmetry</code>.</p><p>In the residual: even harmonics; opposite sign on the rising and the falling branch.</p><p>Looks like: <code>sensor_nonlinearity</code>, <code>amplifier_saturation</code>.</p><p>Distinguished by: slow triangle: the residual over the command, rising and falling apart.</p></html>"));
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
    parameter Real u_start(unit="V") = 0 "Command under which the block rests before the start";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real virgin(unit="V") = max(left_a0*tanh(left_a2) + left_a3, min(right_a0*tanh(right_a2) + right_a3, 0))
      "Play between the envelopes that never moved, at command 0";
    final parameter Real s_start(unit="V") = max(left_a0*tanh(left_a1*u_start + left_a2) + left_a3,
      min(right_a0*tanh(right_a1*u_start + right_a2) + right_a3, virgin)) "Play between the envelopes at the start";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real s(start = s_start, fixed = true, unit="V") "Play between the envelopes";
    discrete Real p[plays](start = Functions.plays(s_start, r, 0, zeros(plays)), each fixed = true, each unit="V") "Plays";
  equation
    when sample(0, step) then
      on = true;
      s = max(left_a0*tanh(left_a1*u + left_a2) + left_a3,
        min(right_a0*tanh(right_a1*u + right_a2) + right_a3, if pre(on) then pre(s) else virgin));
      p = Functions.plays(s, r, 0, pre(p));
    end when;
    y_um = offset + w*p;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-69,-70},{-55,-65},{-35,-45},{8,5},{80,70},{35,70},{-1,60},{-44,20},{-80,-27}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>generalised-play</code>. Asymmetric, saturating hysteresis: plays between hyperbolic-tangent envelopes.</p><p><code>y = offset + sum(w[i]*F[i]); F[i] = max(left(u) - r[i], min(right(u) + r[i], F[i])); left(u) = a0*tanh(a1*u + a2) + a3</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>left_a0</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Rising envelope, height</td></tr><tr><td>left_a1</td><td>1/{command}</td><td>required</td><td>0</td><td></td><td>Rising envelope, steepness</td></tr><tr><td>left_a2</td><td>1</td><td>0</td><td></td><td></td><td>Rising envelope, shift inside</td></tr><tr><td>left_a3</td><td>{command}</td><td>0</td><td></td><td></td><td>Rising envelope, shift outside</td></tr><tr><td>right_a0</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Falling envelope, height</td></tr><tr><td>right_a1</td><td>1/{command}</td><td>required</td><td>0</td><td></td><td>Falling envelope, steepness</td></tr><tr><td>right_a2</td><td>1</td><td>0</td><td></td><td></td><td>Falling envelope, shift inside</td></tr><tr><td>right_a3</td><td>{command}</td><td>0</td><td></td><td></td><td>Falling envelope, shift outside</td></tr></table><p>Source: M. Al Janaideh, S. Rakheja, C.-Y. Su, IEEE/ASME Trans. Mechatronics 16 (2011) 734-744.</p><p>Compensated in front of the machine by inverse-generalised-play (closed form).</p><p>Effect: <code>asymmetry</code>.</p><p>In the residual: even harmonics; opposite sign on the rising and the falling branch.</p><p>Looks like: <code>sensor_nonlinearity</code>, <code>amplifier_saturation</code>.</p><p>Distinguished by: slow triangle: the residual over the command, rising and falling apart.</p></html>"));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-38,-68},{-37,-49},{-12,-49},{-12,-33},{8,-33},{80,70},{40,68},{39,49},{14,49},{13,31},{-11,31},{-13,1},{-37,1},{-39,-45},{-63,-45},{-64,-70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>preisach</code>. Discrete Preisach hysteresis: weighted relays, in constant time per step.</p><p><code>y = offset + sum(mu[i,j]*relay[i,j]), j &lt;= i; a relay is on once u &gt;= t[i] and off once u &lt; t[j]; t[k] = low + k*(high - low)/N</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>relays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>32896</td><td>Number of relays, N*(N + 1)/2</td></tr><tr><td>mu</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Weight of each relay, row by row</td></tr><tr><td>low</td><td>{command}</td><td>required</td><td></td><td></td><td>Command below which all relays are off</td></tr><tr><td>high</td><td>{command}</td><td>required</td><td></td><td></td><td>Command from which on all relays are on</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: I. D. Mayergoyz, Mathematical Models of Hysteresis and Their Applications, 2003.</p><p>Compensated in front of the machine by inverse-preisach (iteration with a bound).</p><p>Effect: <code>hysteresis</code>.</p><p>In the residual: odd harmonics; width of the loop proportional to the amplitude, independent of rate.</p><p>Looks like: <code>backlash</code>, <code>creep</code>, <code>amplifier_bandwidth</code>.</p><p>Distinguished by: loops at two amplitudes and two rates: backlash keeps a constant width, a lag's width grows with the rate.</p></html>"));
  end Preisach;

  block BoucWen "Bouc-Wen hysteresis, symmetric or asymmetric, exact over each step"
    extends Interfaces.Actuator;
    parameter Real gain(unit="um/V", min = 0) "Position per command without hysteresis";
    parameter Real alpha(unit="1", min = 0) "Share of the gain that the hysteresis removes after a reversal";
    parameter Real beta(unit="1/V", min = 0) "Decay of h towards zero on both branches";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-33,-33},{80,70},{46,49},{20,30},{-80,-61}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>bouc-wen</code>. Bouc-Wen hysteresis, symmetric or asymmetric, exact over each step.</p><p><code>y = offset + gain*u - h; dh/du = alpha*gain - (gamma + beta*sgn(u'*h) + delta*sgn(u'))*|h|*|h/hs|^(exponent - 1); hs = alpha*gain/(beta + gamma)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Position per command without hysteresis</td></tr><tr><td>alpha</td><td>1</td><td>required</td><td>0</td><td></td><td>Share of the gain that the hysteresis removes after a reversal</td></tr><tr><td>beta</td><td>1/{command}</td><td>required</td><td>0</td><td></td><td>Decay of h towards zero on both branches</td></tr><tr><td>gamma</td><td>1/{command}</td><td>required</td><td></td><td></td><td>Decay of h that depends on the direction</td></tr><tr><td>delta</td><td>1/{command}</td><td>0</td><td></td><td></td><td>Asymmetry between rising and falling branch</td></tr><tr><td>exponent</td><td>1</td><td>1</td><td>1</td><td>20</td><td>Sharpness of the bend towards saturation</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: F. Ikhouane, J. Rodellar, Systems with Hysteresis, Wiley 2007; J. Song, A. Der Kiureghian, J. Eng. Mech. 132 (2006) 610-618.</p><p>Compensated in front of the machine by inverse-bouc-wen (iteration with a bound), bouc-wen-feedforward (inverse-free).</p><p>Effect: <code>hysteresis</code>.</p><p>In the residual: odd harmonics; width of the loop proportional to the amplitude, independent of rate.</p><p>Looks like: <code>backlash</code>, <code>creep</code>, <code>amplifier_bandwidth</code>.</p><p>Distinguished by: loops at two amplitudes and two rates: backlash keeps a constant width, a lag's width grows with the rate.</p></html>"));
  end BoucWen;

  block Duhem "Duhem hysteresis (Coleman-Hodgdon) with a straight centre line, exact over each step"
    extends Interfaces.Actuator;
    parameter Real slope(unit="um/V") "Slope of the centre line";
    parameter Real initial_(unit="um/V") "Slope right after a reversal";
    parameter Real decay(unit="1/V", min = 0) "Rate at which a branch approaches the major loop, per unit of command";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-22,-24},{80,70},{54,57},{22,34},{-80,-57}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>duhem</code>. Duhem hysteresis (Coleman-Hodgdon) with a straight centre line, exact over each step.</p><p><code>y' = decay*|u'|*(offset + slope*u - y) + initial*u'</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>slope</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Slope of the centre line</td></tr><tr><td>initial</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Slope right after a reversal</td></tr><tr><td>decay</td><td>1/{command}</td><td>required</td><td>0</td><td></td><td>Rate at which a branch approaches the major loop, per unit of command</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: B. D. Coleman, M. L. Hodgdon, Int. J. Eng. Sci. 24 (1986) 897-919.</p><p>Compensated in front of the machine by inverse-duhem (iteration with a bound).</p><p>Effect: <code>hysteresis</code>.</p><p>In the residual: odd harmonics; width of the loop proportional to the amplitude, independent of rate.</p><p>Looks like: <code>backlash</code>, <code>creep</code>, <code>amplifier_bandwidth</code>.</p><p>Distinguished by: loops at two amplitudes and two rates: backlash keeps a constant width, a lag's width grows with the rate.</p></html>"));
  end Duhem;

  block Dahl "Dahl hysteresis: a spring that yields, exact over each step"
    extends Interfaces.Actuator;
    parameter Real gain(unit="um/V") "Slope of the centre line";
    parameter Real height(unit="um", min = 0) "Half height of the major loop";
    parameter Real length(unit="V", min = 0) "Change of the command over which a branch covers 63 % of its distance to the major loop";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-26,-29},{80,70},{57,60},{26,38},{-80,-58}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>dahl</code>. Dahl hysteresis: a spring that yields, exact over each step.</p><p><code>y = offset + gain*u - h; dh/du = height/length*(1 - sgn(u')*h/height)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Slope of the centre line</td></tr><tr><td>height</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Half height of the major loop</td></tr><tr><td>length</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Change of the command over which a branch covers 63 % of its distance to the major loop</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: P. R. Dahl, A solid friction model, Aerospace Corp. TOR-0158(3107-18)-1, 1968.</p><p>Compensated in front of the machine by inverse-dahl (iteration with a bound).</p><p>Effect: <code>hysteresis</code>.</p><p>In the residual: odd harmonics; width of the loop proportional to the amplitude, independent of rate.</p><p>Looks like: <code>backlash</code>, <code>creep</code>, <code>amplifier_bandwidth</code>.</p><p>Distinguished by: loops at two amplitudes and two rates: backlash keeps a constant width, a lag's width grows with the rate.</p></html>"));
  end Dahl;

  block RateDependentPlay "Hysteresis that widens with the rate: plays with rate-dependent thresholds"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real gain(unit="um/V", min = 0) = 0 "Linear part without hysteresis";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-65,-64},{-43,-48},{-17,-26},{8,-1},{80,14},{80,70},{50,58},{6,27},{-46,-17},{-80,-52}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>rate-dependent-play</code>. Hysteresis that widens with the rate: plays with rate-dependent thresholds.</p><p><code>y = offset + gain*u + sum(w[i]*F[i]); F[i] = max(u - t[i], min(u + t[i], F[i])); t[i] = r[i] + rate*|u'|</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>gain</td><td>{position}/{command}</td><td>0</td><td>0</td><td></td><td>Linear part without hysteresis</td></tr><tr><td>rate</td><td>s</td><td>required</td><td>0</td><td></td><td>Growth of every threshold with the command's rate</td></tr></table><p>Source: M. Al Janaideh, P. Krejci, IEEE/ASME Trans. Mechatronics 18 (2013) 1498-1507.</p><p>Compensated in front of the machine by inverse-rate-dependent-play (iteration with a bound).</p><p>Effect: <code>rate_dependence</code>.</p><p>In the residual: grows with rate times amplitude.</p><p>Looks like: <code>amplifier_bandwidth</code>, <code>delay</code>, <code>extra_mode</code>, <code>amplifier_slew</code>.</p><p>Distinguished by: frequency response at 1 % of the amplitude: lag and delay remain, rate dependence vanishes.</p></html>"));
  end RateDependentPlay;

  block LaggingPlay "Hysteresis whose memory lags behind the command"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real gain(unit="um/V", min = 0) = 0 "Linear part without hysteresis";
    parameter Real bandwidth(unit="Hz", min = 0) "Bandwidth of the low-pass before the plays";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-57,-61},{-32,-43},{-6,-18},{8,4},{80,24},{78,57},{75,65},{71,69},{57,68},{17,52},{-40,7},{-71,-27},{-80,-43}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>lagging-play</code>. Hysteresis whose memory lags behind the command.</p><p><code>y = offset + gain*u + sum(w[i]*P[i]); P[i] = max(v - r[i], min(v + r[i], P[i])); v' = 2*pi*bandwidth*(u - v)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>gain</td><td>{position}/{command}</td><td>0</td><td>0</td><td></td><td>Linear part without hysteresis</td></tr><tr><td>bandwidth</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Bandwidth of the low-pass before the plays</td></tr></table><p>Source: K. Kuhnen, European Journal of Control 9 (2003) 407-418.</p><p>Effect: <code>rate_dependence</code>.</p><p>In the residual: grows with rate times amplitude.</p><p>Looks like: <code>amplifier_bandwidth</code>, <code>delay</code>, <code>extra_mode</code>, <code>amplifier_slew</code>.</p><p>Distinguished by: frequency response at 1 % of the amplitude: lag and delay remain, rate dependence vanishes.</p></html>"));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-66,-66},{-44,-52},{-19,-31},{8,-3},{80,-2},{80,70},{57,64},{13,34},{-42,-8},{-80,-47}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>grpi</code>. Generalised rate-dependent Prandtl-Ishlinskii hysteresis.</p><p><code>y = offset + sum(w[i]*P[i]); P[i] = max(hl - r[i], min(hr + r[i], P[i])); hl = a1*u + a2*|u'|; hr = b1*u + b2*|u'|</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>a1</td><td>1</td><td>1</td><td>0</td><td></td><td>Slope of the rising envelope</td></tr><tr><td>a2</td><td>s</td><td>0</td><td></td><td></td><td>Shift of the rising envelope with the rate</td></tr><tr><td>b1</td><td>1</td><td>1</td><td>0</td><td></td><td>Slope of the falling envelope</td></tr><tr><td>b2</td><td>s</td><td>0</td><td></td><td></td><td>Shift of the falling envelope with the rate</td></tr></table><p>Source: C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated Elliptical Vibration Cutting Device, eq. (13).</p><p>Compensated in front of the machine by inverse-grpi (iteration with a bound).</p><p>Effect: <code>rate_dependence</code>.</p><p>In the residual: grows with rate times amplitude.</p><p>Looks like: <code>amplifier_bandwidth</code>, <code>delay</code>, <code>extra_mode</code>, <code>amplifier_slew</code>.</p><p>Distinguished by: frequency response at 1 % of the amplitude: lag and delay remain, rate dependence vanishes.</p></html>"));
  end Grpi;

  block Mpi "Modified rate-dependent Prandtl-Ishlinskii hysteresis: plays and a cubic polynomial"
    extends Interfaces.Actuator;
    parameter Integer plays(min = 1, max = 4096) "Number of play operators";
    parameter Real r[plays](each unit="V", each min = 0) "Threshold of each play, increasing from 0";
    parameter Real w[plays](each unit="um/V", each min = 0) "Weight of each play";
    parameter Real offset(unit="um") = 0 "Position at zero command in the virgin state";
    parameter Real linear(unit="um/V") "Linear part without hysteresis";
    parameter Real cubic(unit="um/(V.V.V)") = 0 "Cubic part without hysteresis";
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-64,-62},{-40,-45},{8,-1},{80,20},{80,70},{48,55},{1,20},{-57,-30},{-80,-52}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>mpi</code>. Modified rate-dependent Prandtl-Ishlinskii hysteresis: plays and a cubic polynomial.</p><p><code>y = offset + linear*u + cubic*u^3 + sum(w[i]*F[i]); F[i] = max(u - t[i], min(u + t[i], F[i])); t[i] = scale*r[i] + rate*|u'|</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr><tr><td>linear</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Linear part without hysteresis</td></tr><tr><td>cubic</td><td>{position}/{command}/{command}/{command}</td><td>0</td><td></td><td></td><td>Cubic part without hysteresis</td></tr><tr><td>scale</td><td>1</td><td>1</td><td>0</td><td></td><td>Factor of all thresholds</td></tr><tr><td>rate</td><td>s</td><td>required</td><td>0</td><td></td><td>Growth of every threshold with the command's rate</td></tr></table><p>Source: polynomial: the Gaussian-process paper's appendix A; play: M. Al Janaideh, P. Krejci, IEEE/ASME Trans. Mechatronics 18 (2013) 1498-1507.</p><p>Compensated in front of the machine by inverse-mpi (iteration with a bound).</p><p>Effect: <code>rate_dependence</code>.</p><p>In the residual: grows with rate times amplitude.</p><p>Looks like: <code>amplifier_bandwidth</code>, <code>delay</code>, <code>extra_mode</code>, <code>amplifier_slew</code>.</p><p>Distinguished by: frequency response at 1 % of the amplitude: lag and delay remain, rate dependence vanishes.</p></html>"));
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
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-66,-68},{-44,-59},{8,-29},{80,70},{80,-2},{80,16},{51,11},{-1,-12},{-44,-33},{-80,-56}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>dynamic-prandtl-ishlinskii</code>. Prandtl-Ishlinskii hysteresis whose weights follow the command's rate in segments.</p><p><code>y = offset + sum((w[i] + phi)*P[i]); phi = alpha[s]*u' + beta[s]*u''; segment s by the signs of u' and u''</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>plays` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Number of play operators</td></tr><tr><td>segments` (structure)</td><td>1</td><td>by its lists</td><td>4</td><td>4</td><td>Number of segments of the loop, four</td></tr><tr><td>r</td><td>{command}</td><td>required</td><td>0</td><td></td><td>Threshold of each play, increasing from 0</td></tr><tr><td>w</td><td>{position}/{command}</td><td>required</td><td>0</td><td></td><td>Weight of each play</td></tr><tr><td>alpha</td><td>{position}.s/{command}/{command}</td><td>required</td><td></td><td></td><td>Change of every weight with the command's rate, per segment</td></tr><tr><td>beta</td><td>{position}.s2/{command}/{command}</td><td>required</td><td></td><td></td><td>Change of every weight with the command's acceleration, per segment</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Position at zero command in the virgin state</td></tr></table><p>Source: C. Zhang et al., Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated Elliptical Vibration Cutting Device, eqs. (3)-(4).</p><p>Compensated in front of the machine by inverse-dynamic-prandtl-ishlinskii (iteration with a bound).</p><p>Effect: <code>rate_dependence</code>.</p><p>In the residual: grows with rate times amplitude.</p><p>Looks like: <code>amplifier_bandwidth</code>, <code>delay</code>, <code>extra_mode</code>, <code>amplifier_slew</code>.</p><p>Distinguished by: frequency response at 1 % of the amplitude: lag and delay remain, rate dependence vanishes.</p></html>"));
  end DynamicPrandtlIshlinskii;
  annotation(Documentation(info="<html><p>Memory of the actuator, one step per sample.</p></html>"));
end Hysteresis;

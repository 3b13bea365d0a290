within Piezoloop;
package Mechanics "Moving mass, flexures, guides and load"
  extends Icons.Package;
  block LoadForce "External load force through the actuator's stiffness, before a mode"
    extends Interfaces.PositionFilter;
    parameter Real stiffness(unit="N/um", min = 0) "Stiffness of the actuator with its flexure";
    Interfaces.ForceInput force "Load force" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
  equation
    y_um = u_um + force/stiffness;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>load-force</code>. External load force through the actuator's stiffness, before a mode.</p><p><code>y = u + force/stiffness</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>stiffness</td><td>N/{position}</td><td>required</td><td>0</td><td></td><td>Stiffness of the actuator with its flexure</td></tr></table><p>Source: A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 3.</p></html>"));
  end LoadForce;

  block Mode "Second-order mode with exact discretisation at any step and any damping"
    extends Interfaces.PositionFilter(y_um(start = 0, fixed = true));
    parameter Real frequency(unit="Hz", min = 0) "Undamped natural frequency";
    parameter Real damping(unit="1", min = 0) "Damping ratio; 1 is critical";
    parameter Real gain(unit="1") = 1 "Static gain";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real v(start = 0, fixed = true, unit="um") "Rate of y over w";
  equation
    when initial() then
      reinit(y_um, gain*u_um);
    end when;
    der(y_um) = w*v;
    der(v) = w*(gain*u_um - y_um - 2*damping*v);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-72,-65},{-65,46},{-61,70},{-49,-49},{-37,53},{-27,-25},{-24,-35},{-13,40},{0,-24},{11,30},{14,26},{24,-16},{27,-12},{36,24},{48,-10},{51,-8},{60,19},{63,16},{72,-6},{76,-3},{80,8}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>mode</code>. Second-order mode with exact discretisation at any step and any damping.</p><p><code>x'' + 2*damping*w*x' + w^2*x = w^2*gain*u; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Undamped natural frequency</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio; 1 is critical</td></tr><tr><td>gain</td><td>1</td><td>1</td><td></td><td></td><td>Static gain</td></tr></table><p>Source: A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 2.</p><p>Effect: <code>extra_mode</code>.</p><p>In the residual: narrow band; ringing after steps.</p><p>Looks like: <code>delay</code>, <code>amplifier_bandwidth</code>, <code>sensor_bandwidth</code>.</p><p>Distinguished by: narrow multisine, or an impulse.</p><p>In <code>p0-truth</code>: 0.330 % at most, 0.188 % rms.</p><p>In <code>p1-truth</code>: 0.520 % at most, 0.216 % rms.</p><p>In <code>p2-truth</code>: 9.956 % at most, 4.063 % rms.</p><p>In <code>evc-truth</code>: 5.244 % at most, 2.373 % rms.</p></html>"));
  end Mode;

  block ModePair "Two second-order modes side by side"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency of the first mode";
    parameter Real damping(unit="1", min = 0) "Damping ratio of the first mode";
    parameter Real second_frequency(unit="Hz", min = 0) "Natural frequency of the second mode";
    parameter Real second_damping(unit="1", min = 0) "Damping ratio of the second mode";
    parameter Real share(unit="1") "Part of the static motion in the second mode";
  protected
    final parameter Real w[2](each unit="rad/s") = 2*Constants.pi*{frequency, second_frequency} "Natural angular frequencies";
    final parameter Real d[2](each unit="1") = {damping, second_damping} "Damping ratios";
    Real x[2](each start = 0, each fixed = true, each unit="um") "Modes";
    Real v[2](each start = 0, each fixed = true, each unit="um") "Their rates over w";
  equation
    when initial() then
      reinit(x, fill(u_um, 2));
    end when;
    for i in 1:2 loop
      der(x[i]) = w[i]*v[i];
      der(v[i]) = w[i]*(u_um - x[i] - 2*d[i]*v[i]);
    end for;
    y_um = (1 - share)*x[1] + share*x[2];
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-68},{-73,-68},{-71,-61},{-60,70},{-49,-70},{-41,37},{-38,51},{-25,-36},{-22,-29},{-11,37},{0,-38},{11,27},{20,-12},{24,-20},{27,-15},{37,19},{40,15},{48,-21},{51,-17},{59,14},{62,12},{71,-10},{76,-9},{80,-1}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>mode-pair</code>. Two second-order modes side by side.</p><p><code>y = (1 - share)*x1 + share*x2; x'' + 2*damping*w*x' + w^2*x = w^2*u for each</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency of the first mode</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio of the first mode</td></tr><tr><td>second_frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency of the second mode</td></tr><tr><td>second_damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio of the second mode</td></tr><tr><td>share</td><td>1</td><td>required</td><td></td><td></td><td>Part of the static motion in the second mode</td></tr></table><p>Source: A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 2.</p><p>Effect: <code>extra_mode</code>.</p><p>In the residual: narrow band; ringing after steps.</p><p>Looks like: <code>delay</code>, <code>amplifier_bandwidth</code>, <code>sensor_bandwidth</code>.</p><p>Distinguished by: narrow multisine, or an impulse.</p><p>In <code>p3-truth</code>: 8.983 % at most, 0.917 % rms.</p><p>In <code>p4-truth</code>: 0.579 % at most, 0.239 % rms.</p></html>"));
  end ModePair;

  block Arx "Discrete transfer function (ARX model) at its own sample time"
    extends Interfaces.PositionFilter;
    parameter Real sample_time(unit="s", min = 1e-09, max = 1000) "Sample time of the transfer function, a whole number of internal steps";
    parameter Integer numerator(min = 1, max = 64) "Number of coefficients b";
    parameter Integer denominator(min = 1, max = 64) "Number of coefficients a";
    parameter Real b[numerator](each unit="1") "Coefficient of each input, the present one first";
    parameter Real a[denominator](each unit="1") "Coefficient of each past output, the last one first";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real ratio(unit="1") = Functions.round(sample_time/step) "Steps in a sample time";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real count(start = 0, fixed = true, unit="1") "Steps since the last sample of the transfer function";
    discrete Real way(start = 0, fixed = true, unit="1") "1 at its samples, -1 in the first step, else 0";
    discrete Real past[numerator](each start = 0, each fixed = true, each unit="um") "Its inputs so far, newest first";
    discrete Real v(start = 0, fixed = true, unit="um") "Its output";
    discrete Real own[denominator](each start = 0, each fixed = true, each unit="um") "Its outputs so far, newest first";
  equation
    when sample(0, step) then
      on = true;
      count = if pre(count) + 1.5 > ratio then 0 else pre(count) + 1;
      way = if not pre(on) then -1 elseif count < 0.5 then 1 else 0;
      past = Functions.enter(u_um, way, pre(past));
      v = if way < -0.5 then sum(b)/(1 + sum(a))*u_um elseif way > 0.5 then b*past - a*pre(own) else pre(v);
      own = Functions.enter(v, way, pre(own));
    end when;
    y_um = v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-69,-9},{-67,-9},{-66,12},{-64,12},{-60,39},{-58,39},{-54,55},{-52,55},{-52,60},{-49,60},{-46,66},{-37,70},{-26,70},{30,59},{80,54}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>arx</code>. Discrete transfer function (ARX model) at its own sample time.</p><p><code>y(k) = sum(b[i]*u(k-i+1)) - sum(a[j]*y(k-j))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>sample_time` (structure)</td><td>s</td><td>by its lists</td><td>0.000000001</td><td>1000</td><td>Sample time of the transfer function, a whole number of internal steps</td></tr><tr><td>numerator` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of coefficients b</td></tr><tr><td>denominator` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of coefficients a</td></tr><tr><td>b</td><td>1</td><td>required</td><td></td><td></td><td>Coefficient of each input, the present one first</td></tr><tr><td>a</td><td>1</td><td>required</td><td></td><td></td><td>Coefficient of each past output, the last one first</td></tr></table><p>Source: laser beam pointing with four piezo axes, eq. (11).</p></html>"));
  end Arx;

  block CollocatedMode "Resonance with its antiresonance"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency of the resonance";
    parameter Real damping(unit="1", min = 0) "Damping ratio of the resonance";
    parameter Real zero_frequency(unit="Hz", min = 0) "Natural frequency of the antiresonance";
    parameter Real zero_damping(unit="1", min = 0) "Damping ratio of the antiresonance";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real x(start = 0, fixed = true, unit="um") "Deflection";
    Real v(start = 0, fixed = true, unit="um") "Its rate over w";
    final parameter Real ratio(unit="1") = frequency/zero_frequency "Resonance over antiresonance";
  equation
    when initial() then
      reinit(x, u_um);
    end when;
    der(x) = w*v;
    der(v) = w*(u_um - x - 2*damping*v);
    y_um = x + ratio^2*(u_um - x - 2*damping*v) + 2*zero_damping*ratio*v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,70},{-62,-50},{-49,55},{-38,-34},{-35,-27},{-25,42},{-13,-24},{-1,32},{2,27},{11,-15},{24,25},{35,-9},{38,-7},{48,20},{60,-5},{62,-4},{72,16},{75,15},{80,4}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>collocated-mode</code>. Resonance with its antiresonance.</p><p><code>G(s) = (s^2/wz^2 + 2*zero_damping*s/wz + 1)/(s^2/wp^2 + 2*damping*s/wp + 1); wp = 2*pi*frequency; wz = 2*pi*zero_frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency of the resonance</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio of the resonance</td></tr><tr><td>zero_frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency of the antiresonance</td></tr><tr><td>zero_damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio of the antiresonance</td></tr></table><p>Source: A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 2.</p><p>Effect: <code>extra_mode</code>.</p><p>In the residual: narrow band; ringing after steps.</p><p>Looks like: <code>delay</code>, <code>amplifier_bandwidth</code>, <code>sensor_bandwidth</code>.</p><p>Distinguished by: narrow multisine, or an impulse.</p></html>"));
  end CollocatedMode;

  block LoadedMode "Second-order mode under a payload mass and an external spring"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Undamped natural frequency without load";
    parameter Real damping(unit="1", min = 0) "Damping ratio without load";
    parameter Real mass(unit="kg", min = 0) "Effective moving mass without load";
    parameter Real payload(unit="kg", min = 0) = 0 "Mass of the payload";
    parameter Real external_stiffness(unit="N/m", min = 0) = 0 "Stiffness to the surroundings";
  protected
    final parameter Real k(unit="N/m") = mass*(2*Constants.pi*frequency)^2 "Stiffness without load";
    final parameter Real c(unit="N.s/m") = 2*damping*sqrt(k*mass) "Viscous damping";
    Real v(unit="um/s") "Rate of y";
  initial equation
    der(y_um) = 0;
    der(v) = 0;
  equation
    der(y_um) = v;
    (mass + payload)*der(v) + c*v + (k + external_stiffness)*y_um = k*u_um;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-71,-61},{-63,48},{-60,70},{-46,-54},{-43,-44},{-35,37},{-32,56},{-29,47},{-18,-42},{-14,-30},{-4,45},{-1,39},{7,-21},{11,-32},{24,36},{27,29},{35,-15},{38,-24},{52,29},{55,25},{62,-10},{66,-18},{69,-14},{80,24}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>loaded-mode</code>. Second-order mode under a payload mass and an external spring.</p><p><code>(m + payload)*x'' + c*x' + (k + external_stiffness)*x = k*u; k = m*(2*pi*frequency)^2; c = 2*damping*sqrt(k*m)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Undamped natural frequency without load</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio without load</td></tr><tr><td>mass</td><td>kg</td><td>required</td><td>0</td><td></td><td>Effective moving mass without load</td></tr><tr><td>payload</td><td>kg</td><td>0</td><td>0</td><td></td><td>Mass of the payload</td></tr><tr><td>external_stiffness</td><td>N/m</td><td>0</td><td>0</td><td></td><td>Stiffness to the surroundings</td></tr></table><p>Source: A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 2.</p><p>Effect: <code>resonance_shift</code>.</p><p>In the residual: around the resonance only, the phase of both signs; with a stiffness the static gain moves as well.</p><p>Looks like: <code>extra_mode</code>, <code>actuator_gain</code>, <code>damping</code>.</p><p>Distinguished by: add a known mass; plot gain against resonance frequency.</p></html>"));
  end LoadedMode;

  block Duffing "Mode whose stiffness grows with its deflection"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency of small motions";
    parameter Real damping(unit="1", min = 0) "Damping ratio";
    parameter Real hardening(unit="1", min = 0) "Relative growth of the stiffness at the reference deflection";
    parameter Real reference(unit="um", min = 0) "Deflection at which the hardening is given";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real x(unit="um") "Deflection";
    Real v(unit="um") "Its rate over w";
    Real inside(unit="1") "x/reference, limited to three times the range";
  initial equation
    der(x) = 0;
    der(v) = 0;
  equation
    der(x) = w*v;
    der(v) = w*(u_um - x - hardening*reference*inside^2*(inside + 3*(x/reference - inside)) - 2*damping*v);
    inside = max(-3, min(3, x/reference));
    y_um = x;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-72,-64},{-62,70},{-52,-50},{-41,56},{-30,-35},{-20,45},{-9,-24},{2,37},{12,-16},{23,30},{34,-10},{45,25},{55,-5},{66,21},{76,-1},{78,-1},{80,2}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>duffing</code>. Mode whose stiffness grows with its deflection.</p><p><code>x'' + 2*damping*w*x' + w^2*x*(1 + hardening*(x/reference)^2) = w^2*u; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency of small motions</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio</td></tr><tr><td>hardening</td><td>1</td><td>required</td><td>0</td><td></td><td>Relative growth of the stiffness at the reference deflection</td></tr><tr><td>reference</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Deflection at which the hardening is given</td></tr></table><p>Source: A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, Wiley 1979, ch. 4.</p><p>Effect: <code>duffing</code>.</p><p>In the residual: the peak moves with the amplitude; jumps in sweeps up and down.</p><p>Looks like: <code>polarisation_saturation</code>, <code>hysteresis</code>.</p><p>Distinguished by: frequency response at three amplitudes.</p></html>"));
  end Duffing;

  block PositionStiffness "Mode whose stiffness depends on the position"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency at the centre";
    parameter Real damping(unit="1", min = 0) "Damping ratio at the centre";
    parameter Real linear(unit="1") = 0 "Relative growth of the stiffness towards the upper end";
    parameter Real quadratic(unit="1") = 0 "Relative growth of the stiffness towards both ends";
    parameter Real centre(unit="um") = 0 "Middle of the range";
    parameter Real half_range(unit="um", min = 0) "Half of the range";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real x(unit="um") "Deflection";
    Real v(unit="um") "Its rate over w";
    Real xi(unit="1") "Place in the range, -1 to 1";
  initial equation
    der(x) = 0;
    der(v) = 0;
  equation
    der(x) = w*v;
    der(v) = w*(u_um - (1 + linear*xi + quadratic*xi^2)*x - 2*damping*v);
    xi = max(-1, min(1, (x - centre)/half_range));
    y_um = x;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-72,-65},{-62,70},{-49,-50},{-38,53},{-26,-35},{-23,-27},{-16,31},{-14,41},{-2,-24},{10,31},{13,26},{22,-16},{34,25},{46,-10},{49,-7},{57,19},{60,17},{70,-6},{80,15}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>position-stiffness</code>. Mode whose stiffness depends on the position.</p><p><code>x'' + 2*damping*w*x' + w^2*s*x = w^2*u; s = 1 + linear*xi + quadratic*xi^2; xi = (x - centre)/half_range, from -1 to 1; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency at the centre</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio at the centre</td></tr><tr><td>linear</td><td>1</td><td>0</td><td></td><td></td><td>Relative growth of the stiffness towards the upper end</td></tr><tr><td>quadratic</td><td>1</td><td>0</td><td></td><td></td><td>Relative growth of the stiffness towards both ends</td></tr><tr><td>centre</td><td>{position}</td><td>0</td><td></td><td></td><td>Middle of the range</td></tr><tr><td>half_range</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Half of the range</td></tr></table><p>Source: S. Henein, Conception des guidages flexibles, PPUR 2001.</p><p>Effect: <code>resonance_shift</code>.</p><p>In the residual: around the resonance only, the phase of both signs; with a stiffness the static gain moves as well.</p><p>Looks like: <code>extra_mode</code>, <code>actuator_gain</code>, <code>damping</code>.</p><p>Distinguished by: add a known mass; plot gain against resonance frequency.</p></html>"));
  end PositionStiffness;

  block Friction "Mode with LuGre friction"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Undamped natural frequency";
    parameter Real damping(unit="1", min = 0) "Damping ratio";
    parameter Real coulomb(unit="um", min = 0) "Coulomb friction over stiffness";
    parameter Real stiction(unit="um", min = 0) "Static friction over stiffness";
    parameter Real presliding(unit="um", min = 0) "Bristle deflection at the Coulomb force";
    parameter Real stribeck(unit="um/s", min = 0) "Velocity at which static friction has fallen to 37 %";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real v(unit="um/s") "Rate of y";
    Real z(unit="um") "Deflection of the bristles";
    Real g(unit="um") "Its steady value at this speed";
  initial equation
    der(y_um) = 0;
    der(v) = 0;
    z = 0;
  equation
    g = presliding*(1 + (stiction/coulomb - 1)*exp(-(v/stribeck)^2));
    der(y_um) = v;
    der(v) = w^2*(u_um - y_um - coulomb*z/presliding) - 2*damping*w*v;
    der(z) = v - abs(v)*z/g;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-72,-65},{-65,46},{-61,70},{-49,-40},{-37,45},{-25,-18},{-13,26},{-1,-2},{10,13},{19,8},{80,8}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>friction</code>. Mode with LuGre friction.</p><p><code>x'' + 2*damping*w*x' + w^2*(x + coulomb*z/presliding) = w^2*u; z' = x' - |x'|*z/g; g = presliding*(1 + (stiction/coulomb - 1)*exp(-(x'/stribeck)^2))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Undamped natural frequency</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio</td></tr><tr><td>coulomb</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Coulomb friction over stiffness</td></tr><tr><td>stiction</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Static friction over stiffness</td></tr><tr><td>presliding</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Bristle deflection at the Coulomb force</td></tr><tr><td>stribeck</td><td>{position}/s</td><td>required</td><td>0</td><td></td><td>Velocity at which static friction has fallen to 37 %</td></tr></table><p>Source: C. Canudas de Wit et al., IEEE Trans. Automatic Control 40 (1995) 419-425.</p><p>Effect: <code>friction</code>.</p><p>In the residual: steps at reversals, stairs; limit cycles in closed loop.</p><p>Looks like: <code>backlash</code>, <code>hysteresis</code>.</p><p>Distinguished by: pre-sliding test: below break-away it is a spring.</p></html>"));
  end Friction;

  block NonlinearDamping "Mode with Coulomb friction and speed-dependent damping"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Undamped natural frequency";
    parameter Real damping(unit="1", min = 0) "Damping ratio at small velocities";
    parameter Real coulomb(unit="um", min = 0) = 0 "Coulomb friction over stiffness";
    parameter Real velocity(unit="um/s", min = 0) = 1 "Velocity at which 76 % of the Coulomb friction acts";
    parameter Real growth(unit="s/um", min = 0) = 0 "Growth of the damping ratio with the speed";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real v(unit="um/s") "Rate of y";
  initial equation
    der(y_um) = 0;
    der(v) = 0;
  equation
    der(y_um) = v;
    der(v) = w^2*(u_um - y_um - coulomb*tanh(v/velocity)) - 2*(damping + growth*abs(v))*w*v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-72,-64},{-65,47},{-61,70},{-49,-7},{-39,36},{-36,41},{-24,11},{-12,29},{0,20},{14,22},{80,22}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>nonlinear-damping</code>. Mode with Coulomb friction and speed-dependent damping.</p><p><code>x'' + 2*(damping + growth*|x'|)*w*x' + w^2*(x + coulomb*tanh(x'/velocity)) = w^2*u; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Undamped natural frequency</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio at small velocities</td></tr><tr><td>coulomb</td><td>{position}</td><td>0</td><td>0</td><td></td><td>Coulomb friction over stiffness</td></tr><tr><td>velocity</td><td>{position}/s</td><td>1</td><td>0</td><td></td><td>Velocity at which 76 % of the Coulomb friction acts</td></tr><tr><td>growth</td><td>s/{position}</td><td>0</td><td>0</td><td></td><td>Growth of the damping ratio with the speed</td></tr></table><p>Source: A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, Wiley 1979, ch. 3.</p><p>Effect: <code>damping</code>.</p><p>In the residual: height of the resonance peak only.</p><p>Looks like: <code>resonance_shift</code>.</p><p>Distinguished by: ring-down after a step.</p></html>"));
  end NonlinearDamping;

  block Backlash "Clearance, as a play of constant width"
    extends Interfaces.PositionFilter;
    parameter Real width(unit="um", min = 0) "Clearance";
    parameter Real bridge(unit="1", min = 0, max = 1) = 0 "Share of a motion that passes within the clearance";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real p(start = 0, fixed = true, unit="um") "Play";
    discrete Real x(start = 0, fixed = true, unit="um") "Input of the sample";
  equation
    when sample(0, step) then
      p = Functions.play(u_um, width/2, pre(p));
      x = u_um;
    end when;
    y_um = p + bridge*(x - p);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-69},{80,70},{65,67},{-80,-65}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>backlash</code>. Clearance, as a play of constant width.</p><p><code>y = bridge x + (1 - bridge) P, P = max(x - width/2, min(x + width/2, P))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>width</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Clearance</td></tr><tr><td>bridge</td><td>1</td><td>0</td><td>0</td><td>1</td><td>Share of a motion that passes within the clearance</td></tr></table><p>Source: G. Tao, P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley 1996.</p><p>Effect: <code>backlash</code>.</p><p>In the residual: loop of constant width, dead band at reversals.</p><p>Looks like: <code>hysteresis</code>, <code>friction</code>.</p><p>Distinguished by: triangle of tiny amplitude: below the clearance the stroke vanishes.</p></html>"));
  end Backlash;

  block CuttingForce "Cutting force once per ellipse, while the tool is in cut"
    extends Interfaces.PositionFilter;
    parameter Real amplitude(unit="um") "Greatest force over stiffness";
    parameter Real frequency(unit="Hz", min = 0) "Frequency of the ellipse";
    parameter Real duty(unit="1", min = 0, max = 1) = 0.3 "Part of the period in cut";
    parameter Real phase(unit="rad") = 0 "Phase at time 0";
  protected
    Real part(unit="1") "Part of the period that is past";
  equation
    part = frequency*time + phase/(2*Constants.pi) - floor(frequency*time + phase/(2*Constants.pi));
    y_um = if part < duty then u_um + amplitude*sin(Constants.pi*part/duty) else u_um;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-6},{-76,70},{-70,-70},{-52,-70},{-45,70},{-39,-70},{-21,-70},{-15,70},{-8,-70},{10,-70},{16,70},{22,-70},{40,-70},{47,70},{53,-70},{71,-70},{76,62},{78,68},{80,38}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>cutting-force</code>. Cutting force once per ellipse, while the tool is in cut.</p><p><code>y = x + amplitude*sin(pi*p/duty) for p &lt; duty, else x; p = frac(frequency*t + phase/(2*pi))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>amplitude</td><td>{position}</td><td>required</td><td></td><td></td><td>Greatest force over stiffness</td></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Frequency of the ellipse</td></tr><tr><td>duty</td><td>1</td><td>0.3</td><td>0</td><td>1</td><td>Part of the period in cut</td></tr><tr><td>phase</td><td>rad</td><td>0</td><td></td><td></td><td>Phase at time 0</td></tr></table><p>Source: E. Shamoto, T. Moriwaki, CIRP Annals 43 (1994) 35-38.</p><p>Effect: <code>periodic_disturbance</code>.</p><p>In the residual: lines at the disturbance's frequency and its harmonics; a cutting force only while in cut.</p><p>Looks like: <code>hysteresis</code>, <code>mains_hum</code>.</p><p>Distinguished by: air cut against cut; record at zero command.</p></html>"));
  end CuttingForce;

  block Vibration "Vibration at fixed frequencies"
    extends Interfaces.PositionFilter;
    parameter Integer lines(min = 1, max = 64) "Number of lines";
    parameter Real frequency[lines](each unit="Hz", each min = 0) "Frequency of each line";
    parameter Real amplitude[lines](each unit="um") "Amplitude of each line";
    parameter Real phase[lines](each unit="rad") "Phase of each line at time 0";
  equation
    y_um = u_um + sum(amplitude[i]*sin(2*Constants.pi*frequency[i]*time + phase[i]) for i in 1:lines);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-4},{-71,57},{-68,67},{-66,67},{-53,10},{-49,8},{-42,16},{-38,11},{-27,-59},{-22,-70},{-7,-4},{-4,0},{4,-8},{7,-2},{18,60},{22,70},{27,59},{37,-4},{41,-9},{48,-2},{52,-4},{66,-69},{68,-69},{71,-59},{80,-1}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>vibration</code>. Vibration at fixed frequencies.</p><p><code>y = x + sum(amplitude[i]*sin(2*pi*frequency[i]*t + phase[i]))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>lines` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of lines</td></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Frequency of each line</td></tr><tr><td>amplitude</td><td>{position}</td><td>required</td><td></td><td></td><td>Amplitude of each line</td></tr><tr><td>phase</td><td>rad</td><td>required</td><td></td><td></td><td>Phase of each line at time 0</td></tr></table><p>Source: sum of sines.</p><p>Effect: <code>periodic_disturbance</code>.</p><p>In the residual: lines at the disturbance's frequency and its harmonics; a cutting force only while in cut.</p><p>Looks like: <code>hysteresis</code>, <code>mains_hum</code>.</p><p>Distinguished by: air cut against cut; record at zero command.</p></html>"));
  end Vibration;

  block MechanicalPort "Mechanical port of the axis: position and velocity of its tip as outputs, in SI"
    extends Interfaces.PositionFilter;
    Interfaces.PositionOutput tip "Position of the tip behind the mechanics" annotation(Placement(transformation(extent={{100,40},{120,60}})));
    output Types.Velocity tip_velocity "Velocity of the tip, mean of the step";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Types.Position last(start = 0, fixed = true) "Position at the last sample";
    discrete Types.Velocity v(start = 0, fixed = true) "Mean velocity of the last step";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      last = u;
      v = if pre(on) then (last - pre(last))/step else 0;
    end when;
    y_um = u_um;
    tip = u;
    tip_velocity = v;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,0},{20,0}}, color={0,127,0}, thickness=0.5), Rectangle(extent={{20,-30},{40,30}}, lineColor={0,127,0}, fillColor={0,127,0}, fillPattern=FillPattern.Solid), Line(points={{40,0},{80,0},{66,10},{80,0},{66,-10}}, color={0,127,0})}),
      Documentation(info="<html><p>Component <code>mechanical-port</code>. Mechanical port of the axis: position and velocity of its tip as outputs, in SI.</p><p><code>tip = x; tip_velocity = dx/dt</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr></table><p>Source: F. E. Cellier, Continuous System Modeling, Springer 1991, ch. 7.</p></html>"));
  end MechanicalPort;
  package Translational "Components with flanges: plug-compatible with Modelica.Mechanics.Translational"
    extends Icons.Package;

    model Fixed "Point that does not move"
      Interfaces.Flange_b flange "Fixed flange" annotation(Placement(transformation(extent={{-10,-10},{10,10}})));
      parameter Real at(unit="m") = 0 "Position";
    equation
      flange.s = at;
      annotation(Icon(graphics={Line(points={{-80,-40},{80,-40}}), Line(points={{-60,-80},{-40,-40}}), Line(points={{-20,-80},{0,-40}}), Line(points={{20,-80},{40,-40}}), Line(points={{0,-40},{0,0}}), Text(extent={{-150,30},{150,70}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>flange.s = at</code></p></html>"));
    end Fixed;

    model Mass "Moving mass or payload"
      extends Interfaces.TwoFlanges;
      parameter Real m(unit="kg", min = 0) = 0.1 "Mass";
      Types.Position s(start = 0, fixed = true) "Position";
      Types.Velocity v(start = 0, fixed = true) "Velocity";
      Types.Energy stored "Kinetic energy";
    equation
      s = flange_a.s;
      s = flange_b.s;
      v = der(s);
      m*der(v) = flange_a.f + flange_b.f;
      stored = 0.5*m*v^2;
      annotation(Icon(graphics={Rectangle(extent={{-60,-40},{60,40}}, lineColor={0,0,0}, fillColor={86,180,233}, fillPattern=FillPattern.Solid), Line(points={{-90,0},{-60,0}}, color={0,127,0}), Line(points={{60,0},{90,0}}, color={0,127,0}), Text(extent={{-150,60},{150,100}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>m*s'' = sum of the forces</code>; starts at rest at 0.</p></html>"));
    end Mass;

    model Flexure "Flexure: spring with viscous damping and a cubic term"
      extends Interfaces.TwoFlanges;
      parameter Real stiffness(unit="N/m", min = 0) = 1e6 "Stiffness for small deflections";
      parameter Real cubic(unit="N/m3") = 0 "Cubic stiffness (Duffing): above zero hardens";
      parameter Real damping(unit="N.s/m", min = 0) = 0 "Viscous damping";
      parameter Real length(unit="m") = 0 "Distance of the flanges at rest";
      Types.Position deflection "Deflection";
      Types.Force f "Pull";
      Types.Energy stored "Elastic energy";
      Types.Energy dissipated(start = 0, fixed = true) "Loss";
    equation
      deflection = flange_b.s - flange_a.s - length;
      f = stiffness*deflection + cubic*deflection^3 + damping*der(deflection);
      flange_b.f = f;
      flange_a.f = -f;
      stored = 0.5*stiffness*deflection^2 + 0.25*cubic*deflection^4;
      der(dissipated) = damping*der(deflection)^2;
      annotation(Icon(graphics={Line(points={{-90,0},{-60,0},{-50,30},{-30,-30},{-10,30},{10,-30},{30,30},{50,-30},{60,0},{90,0}}, color={0,127,0}), Text(extent={{-150,60},{150,100}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>f = stiffness*x + cubic*x^3 + damping*x'</code>. Look-alikes: block <code>Mechanics.Duffing</code> (cubic term), <code>LoadedMode</code> (external stiffness).</p></html>"));
    end Flexure;

    model Clearance "Gap between two elastic stops"
      extends Interfaces.TwoFlanges;
      parameter Real width(unit="m", min = 0) = 1e-6 "Free motion between the stops";
      parameter Real stiffness(unit="N/m", min = 0) = 1e8 "Stiffness of a stop";
      Types.Position x "Distance from the middle of the gap";
      Types.Force f "Force between the flanges";
      Types.Energy stored "Elastic energy of the stops";
    equation
      x = flange_b.s - flange_a.s;
      f = stiffness*(max(0, x - 0.5*width) + min(0, x + 0.5*width));
      flange_b.f = f;
      flange_a.f = -f;
      stored = 0.5*stiffness*(max(0, x - 0.5*width)^2 + min(0, x + 0.5*width)^2);
      annotation(Icon(graphics={Line(points={{-90,0},{-20,0},{-20,40}}, color={0,127,0}), Line(points={{-20,0},{-20,-40}}, color={0,127,0}), Line(points={{20,40},{20,-40}}, color={0,127,0}), Line(points={{20,0},{90,0}}, color={0,127,0}), Text(extent={{-150,60},{150,100}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>f = stiffness*(max(0, x - width/2) + min(0, x + width/2))</code>. Look-alike: block <code>Mechanics.Backlash</code>, which has rigid stops and friction that holds the output.</p></html>"));
    end Clearance;

    model Friction "Dry friction with pre-sliding (Dahl)"
      extends Interfaces.TwoFlanges;
      parameter Real coulomb(unit="N", min = 0) = 1 "Friction force when sliding";
      parameter Real presliding(unit="m", min = 0) = 1e-7 "Deflection at which it slides";
      parameter Real viscous(unit="N.s/m", min = 0) = 0 "Viscous friction";
      Types.Velocity v "Sliding velocity";
      Real z(start = 0, fixed = true, unit="1") "Share of the friction force";
      Types.Force f "Friction force";
      Types.Energy stored "Elastic energy of the contact";
      Types.Energy dissipated(start = 0, fixed = true) "Heat";
    equation
      v = der(flange_b.s) - der(flange_a.s);
      presliding*der(z) = v - abs(v)*z;
      f = coulomb*z + viscous*v;
      flange_b.f = f;
      flange_a.f = -f;
      stored = 0.5*coulomb*presliding*z^2;
      der(dissipated) = coulomb*abs(v)*z^2 + viscous*v^2;
      annotation(Icon(graphics={Rectangle(extent={{-60,0},{60,40}}, lineColor={0,0,0}, fillColor={200,200,200}, fillPattern=FillPattern.Solid), Line(points={{-90,0},{90,0}}, color={0,127,0}), Line(points={{-60,-10},{-40,-30}}), Line(points={{-20,-10},{0,-30}}), Line(points={{20,-10},{40,-30}}), Text(extent={{-150,60},{150,100}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>presliding*z' = v - |v|*z; f = coulomb*z + viscous*v</code>. Look-alike: block <code>Mechanics.Friction</code>, which has stiction and the Stribeck effect. Source: P. Dahl, A solid friction model, 1968.</p></html>"));
    end Friction;

    model Force "Force from a signal on a flange"
      Interfaces.ForceInput f "Force in the direction of the axis" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
      Interfaces.Flange_b flange "Where it acts" annotation(Placement(transformation(extent={{90,-10},{110,10}})));
      Types.Energy delivered(start = 0, fixed = true) "Work done";
    equation
      flange.f = -f;
      der(delivered) = f*der(flange.s);
      annotation(Icon(graphics={Polygon(points={{-80,15},{20,15},{20,45},{80,0},{20,-45},{20,-15},{-80,-15}}, lineColor={0,127,0}, fillColor={215,235,215}, fillPattern=FillPattern.Solid), Text(extent={{-150,60},{150,100}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>flange.f = -f</code></p></html>"));
    end Force;

    model PositionSensor "Position of a flange as a signal"
      Interfaces.Flange_a flange "Where it is read" annotation(Placement(transformation(extent={{-110,-10},{-90,10}})));
      Interfaces.PositionOutput y "Position" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    equation
      flange.f = 0;
      y = flange.s;
      annotation(Icon(graphics={Rectangle(extent={{-60,-40},{60,40}}, lineColor={0,0,0}, fillColor={245,245,245}, fillPattern=FillPattern.Solid), Text(extent={{-50,-30},{50,30}}, textString="s", textColor={0,0,0}), Line(points={{-90,0},{-60,0}}, color={0,127,0}), Line(points={{60,0},{100,0}}, color={0,0,127}), Text(extent={{-150,60},{150,100}}, textString="%name", textColor={0,0,255})}),
        Documentation(info="<html><p><code>y = flange.s</code>, without force. Blocks of <code>Sensors</code> follow.</p></html>"));
    end PositionSensor;
    annotation(Documentation(info="<html><p>Mass, flexure, clearance, friction, force and reading with flanges. Parameters are in SI.</p></html>"));
  end Translational;
  annotation(Documentation(info="<html><p>Mechanics as blocks of a signal path; <code>Translational</code>: with flanges.</p></html>"));
end Mechanics;

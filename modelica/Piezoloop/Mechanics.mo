within Piezoloop;
package Mechanics "Moving mass, flexures, guides and load"
  block LoadForce "Load force from outside, through the actuator's stiffness, in front of a mode"
    extends Interfaces.PositionFilter;
    parameter Real stiffness(unit="N/um", min = 0) "Stiffness of the actuator with its flexure";
    Interfaces.ForceInput force "Load force";
  equation
    y_um = u_um + force/stiffness;
    annotation(Documentation(info="<html><p>Component <code>load-force</code>:</p><p><code>y = u + force/stiffness</code></p></html>"));
  end LoadForce;

  block Mode "Second-order mode with exact discretisation at any step and any damping"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Undamped natural frequency";
    parameter Real damping(unit="1", min = 0) "Damping ratio; 1 is critical";
    parameter Real gain(unit="1") = 1 "Static gain";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real v(unit="um") "Rate of y over w";
  initial equation
    der(y_um) = 0;
    der(v) = 0;
  equation
    der(y_um) = w*v;
    der(v) = w*(gain*u_um - y_um - 2*damping*v);
    annotation(Documentation(info="<html><p>Component <code>mode</code>:</p><p><code>x'' + 2*damping*w*x' + w^2*x = w^2*gain*u; w = 2*pi*frequency</code></p></html>"));
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
    Real x[2](each unit="um") "Modes";
    Real v[2](each unit="um") "Their rates over w";
  initial equation
    for i in 1:2 loop
      der(x[i]) = 0;
      der(v[i]) = 0;
    end for;
  equation
    for i in 1:2 loop
      der(x[i]) = w[i]*v[i];
      der(v[i]) = w[i]*(u_um - x[i] - 2*d[i]*v[i]);
    end for;
    y_um = (1 - share)*x[1] + share*x[2];
    annotation(Documentation(info="<html><p>Component <code>mode-pair</code>:</p><p><code>y = (1 - share)*x1 + share*x2; x'' + 2*damping*w*x' + w^2*x = w^2*u for each</code></p></html>"));
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
    annotation(Documentation(info="<html><p>Component <code>arx</code>:</p><p><code>y(k) = sum(b[i]*u(k-i+1)) - sum(a[j]*y(k-j))</code></p></html>"));
  end Arx;

  block CollocatedMode "Resonance with its antiresonance"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency of the resonance";
    parameter Real damping(unit="1", min = 0) "Damping ratio of the resonance";
    parameter Real zero_frequency(unit="Hz", min = 0) "Natural frequency of the antiresonance";
    parameter Real zero_damping(unit="1", min = 0) "Damping ratio of the antiresonance";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real x(unit="um") "Deflection";
    Real v(unit="um") "Its rate over w";
    final parameter Real ratio(unit="1") = frequency/zero_frequency "Resonance over antiresonance";
  initial equation
    der(x) = 0;
    der(v) = 0;
  equation
    der(x) = w*v;
    der(v) = w*(u_um - x - 2*damping*v);
    y_um = x + ratio^2*(u_um - x - 2*damping*v) + 2*zero_damping*ratio*v;
    annotation(Documentation(info="<html><p>Component <code>collocated-mode</code>:</p><p><code>G(s) = (s^2/wz^2 + 2*zero_damping*s/wz + 1)/(s^2/wp^2 + 2*damping*s/wp + 1); wp = 2*pi*frequency; wz = 2*pi*zero_frequency</code></p></html>"));
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
    annotation(Documentation(info="<html><p>Component <code>loaded-mode</code>:</p><p><code>(m + payload)*x'' + c*x' + (k + external_stiffness)*x = k*u; k = m*(2*pi*frequency)^2; c = 2*damping*sqrt(k*m)</code></p></html>"));
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
    annotation(Documentation(info="<html><p>Component <code>duffing</code>:</p><p><code>x'' + 2*damping*w*x' + w^2*x*(1 + hardening*(x/reference)^2) = w^2*u; w = 2*pi*frequency</code></p></html>"));
  end Duffing;

  block PositionStiffness "Mode whose stiffness depends on the position"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency at the centre";
    parameter Real damping(unit="1", min = 0) "Damping ratio at the centre";
    parameter Real linear(unit="1") = 0 "Relative growth of the stiffness to the upper end";
    parameter Real quadratic(unit="1") = 0 "Relative growth of the stiffness to both ends";
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
    annotation(Documentation(info="<html><p>Component <code>position-stiffness</code>:</p><p><code>x'' + 2*damping*w*x' + w^2*s*x = w^2*u; s = 1 + linear*xi + quadratic*xi^2; xi = (x - centre)/half_range, from -1 to 1; w = 2*pi*frequency</code></p></html>"));
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
    annotation(Documentation(info="<html><p>Component <code>friction</code>:</p><p><code>x'' + 2*damping*w*x' + w^2*(x + coulomb*z/presliding) = w^2*u; z' = x' - |x'|*z/g; g = presliding*(1 + (stiction/coulomb - 1)*exp(-(x'/stribeck)^2))</code></p></html>"));
  end Friction;

  block NonlinearDamping "Mode with Coulomb friction and damping that grows with the speed"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Undamped natural frequency";
    parameter Real damping(unit="1", min = 0) "Damping ratio at small velocities";
    parameter Real coulomb(unit="um", min = 0) = 0 "Coulomb friction over stiffness";
    parameter Real velocity(unit="um/s", min = 0) = 1 "Velocity of 76 % of the Coulomb friction";
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
    annotation(Documentation(info="<html><p>Component <code>nonlinear-damping</code>:</p><p><code>x'' + 2*(damping + growth*|x'|)*w*x' + w^2*(x + coulomb*tanh(x'/velocity)) = w^2*u; w = 2*pi*frequency</code></p></html>"));
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
    annotation(Documentation(info="<html><p>Component <code>backlash</code>:</p><p><code>y = bridge x + (1 - bridge) P, P = max(x - width/2, min(x + width/2, P))</code></p></html>"));
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
    annotation(Documentation(info="<html><p>Component <code>cutting-force</code>:</p><p><code>y = x + amplitude*sin(pi*p/duty) for p &lt; duty, else x; p = frac(frequency*t + phase/(2*pi))</code></p></html>"));
  end CuttingForce;

  block Vibration "Vibration at fixed frequencies"
    extends Interfaces.PositionFilter;
    parameter Integer lines(min = 1, max = 64) "Number of lines";
    parameter Real frequency[lines](each unit="Hz", each min = 0) "Frequency of each line";
    parameter Real amplitude[lines](each unit="um") "Amplitude of each line";
    parameter Real phase[lines](each unit="rad") "Phase of each line at time 0";
  equation
    y_um = u_um + sum(amplitude[i]*sin(2*Constants.pi*frequency[i]*time + phase[i]) for i in 1:lines);
    annotation(Documentation(info="<html><p>Component <code>vibration</code>:</p><p><code>y = x + sum(amplitude[i]*sin(2*pi*frequency[i]*t + phase[i]))</code></p></html>"));
  end Vibration;
end Mechanics;

within Piezoloop;
package Sensors "Position sensor and its conditioning"
  extends Icons.Package;
  block SensorLag "First-order bandwidth of the sensor and its filter"
    extends Interfaces.PositionFilter(y_um(start = 0, fixed = true));
    parameter Real bandwidth(unit="Hz", min = 0) "Frequency at which the reading has fallen by 3 dB";
  equation
    when initial() then
      reinit(y_um, u_um);
    end when;
    der(y_um)/(2*Constants.pi*bandwidth) + y_um = u_um;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-71,33},{-69,60},{-66,68},{-59,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>sensor-lag</code>. First-order bandwidth of the sensor and its filter.</p><p><code>y'/(2*pi*bandwidth) + y = x</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>bandwidth</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Frequency at which the reading has fallen by 3 dB</td></tr></table><p>Source: A. J. Fleming, A review of nanometer resolution position sensors, Sensors and Actuators A 190 (2013) 106-126.</p><p>Effect: <code>sensor_bandwidth</code>.</p><p>In the residual: the reading lags although the voltage is prompt, independent of amplitude.</p><p>Looks like: <code>amplifier_bandwidth</code>, <code>delay</code>.</p><p>Distinguished by: monitor voltage and a second sensor.</p><p>In <code>p1-truth</code>: 4.0e-6 % at most, 1.6e-6 % rms.</p><p>In <code>p2-truth</code>: 0.132 % at most, 0.049 % rms.</p><p>In <code>p3-truth</code>: 0.036 % at most, 0.006 % rms.</p><p>In <code>p4-truth</code>: 0.490 % at most, 0.281 % rms.</p><p>In <code>evc-truth</code>: 0.510 % at most, 0.251 % rms.</p></html>"));
  end SensorLag;

  block SensorSecondOrder "Second-order bandwidth of the sensor and its filter"
    extends Interfaces.PositionFilter(y_um(start = 0, fixed = true));
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency";
    parameter Real damping(unit="1", min = 0) = 0.707 "Damping ratio; 0.707 is flat";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real v(start = 0, fixed = true, unit="um") "Rate of y over w";
  equation
    when initial() then
      reinit(y_um, u_um);
    end when;
    der(y_um) = w*v;
    der(v) = w*(u_um - y_um - 2*damping*v);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-68,69},{-61,64},{80,64}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>sensor-second-order</code>. Second-order bandwidth of the sensor and its filter.</p><p><code>y'' + 2*damping*w*y' + w^2*y = w^2*x; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Natural frequency</td></tr><tr><td>damping</td><td>1</td><td>0.707</td><td>0</td><td></td><td>Damping ratio; 0.707 is flat</td></tr></table><p>Source: A. J. Fleming, Sensors and Actuators A 190 (2013) 106-126.</p><p>Effect: <code>sensor_bandwidth</code>.</p><p>In the residual: the reading lags although the voltage is prompt, independent of amplitude.</p><p>Looks like: <code>amplifier_bandwidth</code>, <code>delay</code>.</p><p>Distinguished by: monitor voltage and a second sensor.</p></html>"));
  end SensorSecondOrder;

  block SensorButterworth "Butterworth low-pass of the sensor, orders 1 to 8"
    extends Interfaces.PositionFilter;
    parameter Integer order(min = 1, max = 8) = 2 "Order of the filter";
    parameter Real bandwidth(unit="Hz", min = 0) "Frequency at which the reading has fallen by 3 dB";
  protected
    final parameter Integer pairs = div(order, 2) "Number of pairs of poles";
    final parameter Integer odd = mod(order, 2) "1 for a real pole beside them";
    final parameter Real w(unit="rad/s") = 2*Constants.pi*bandwidth "Angular frequency of the bandwidth";
    Real s[pairs + 1](each start = 0, each fixed = true, each unit="um") "Signal behind each pair; the last one behind the real pole of an odd order";
    Real v[pairs](each start = 0, each fixed = true, each unit="um") "Rate behind each pair over w";
    Real x(unit="um") "Signal in front of the pairs";
  equation
    when initial() then
      reinit(s, fill(u_um, pairs + 1));
    end when;
    der(s[pairs + 1]) = w*(u_um - s[pairs + 1]);
    x = if odd > 0 then s[pairs + 1] else u_um;
    for i in 1:pairs loop
      der(s[i]) = w*v[i];
      der(v[i]) = w*((if i > 1 then s[max(i - 1, 1)] else x) - s[i] - 2*sin(Constants.pi*(2*i - 1)/(2*order))*v[i]);
    end for;
    y_um = if pairs > 0 then s[max(pairs, 1)] else x;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-72,-70},{-70,-62},{-64,50},{-61,70},{-55,49},{-49,56},{-42,53},{80,54}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>sensor-butterworth</code>. Butterworth low-pass of the sensor, orders 1 to 8.</p><p><code>|G(j*2*pi*f)|^2 = 1/(1 + (f/bandwidth)^(2*order))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>order` (structure)</td><td>1</td><td>2</td><td>1</td><td>8</td><td>Order of the filter</td></tr><tr><td>bandwidth</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Frequency at which the reading has fallen by 3 dB</td></tr></table><p>Source: S. Butterworth, Experimental Wireless and the Wireless Engineer 7 (1930) 536-541.</p><p>Effect: <code>sensor_bandwidth</code>.</p><p>In the residual: the reading lags although the voltage is prompt, independent of amplitude.</p><p>Looks like: <code>amplifier_bandwidth</code>, <code>delay</code>.</p><p>Distinguished by: monitor voltage and a second sensor.</p><p>In <code>p0-truth</code>: 12.909 % at most, 7.541 % rms.</p><p>In <code>p1-truth</code>: 22.351 % at most, 8.652 % rms.</p></html>"));
  end SensorButterworth;

  block SensorScale "Gain and offset of the sensor"
    extends Interfaces.PositionFilter;
    parameter Real gain(unit="1") = 1 "Reading per position";
    parameter Real offset(unit="um") = 0 "Reading at position 0";
  equation
    y_um = gain*u_um + offset;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>sensor-scale</code>. Gain and offset of the sensor.</p><p><code>y = gain*x + offset</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>1</td><td>1</td><td></td><td></td><td>Reading per position</td></tr><tr><td>offset</td><td>{position}</td><td>0</td><td></td><td></td><td>Reading at position 0</td></tr></table><p>Source: linear sensor.</p><p>Effect: <code>actuator_gain</code>.</p><p>In the residual: proportional to the signal at all frequencies below the first resonance.</p><p>Looks like: <code>resonance_shift</code>, <code>sensor_nonlinearity</code>.</p><p>Distinguished by: a second sensor or the monitor voltage; log the temperature.</p></html>"));
  end SensorScale;

  block SensorPolynomial "Static nonlinearity of the sensor, quadratic and cubic"
    extends Interfaces.PositionFilter;
    parameter Real quadratic(unit="1") = 0 "Quadratic deviation at the end of the range";
    parameter Real cubic(unit="1") = 0 "Cubic deviation at the end of the range";
    parameter Real centre(unit="um") "Middle of the range";
    parameter Real half_range(unit="um", min = 0) "Half of the range";
  protected
    Real xi(unit="1") "Place in the range, -1 to 1";
  equation
    xi = (u_um - centre)/half_range;
    y_um = u_um + half_range*(quadratic*xi^2 + cubic*xi^3);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{62,54},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>sensor-polynomial</code>. Static nonlinearity of the sensor, quadratic and cubic.</p><p><code>y = x + half_range*(quadratic*xi^2 + cubic*xi^3); xi = (x - centre)/half_range</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>quadratic</td><td>1</td><td>0</td><td></td><td></td><td>Quadratic deviation at the end of the range</td></tr><tr><td>cubic</td><td>1</td><td>0</td><td></td><td></td><td>Cubic deviation at the end of the range</td></tr><tr><td>centre</td><td>{position}</td><td>required</td><td></td><td></td><td>Middle of the range</td></tr><tr><td>half_range</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Half of the range</td></tr></table><p>Source: A. J. Fleming, Sensors and Actuators A 190 (2013) 106-126.</p><p>Effect: <code>sensor_nonlinearity</code>.</p><p>In the residual: a polynomial of the position, the same on both branches and at every rate.</p><p>Looks like: <code>asymmetry</code>, <code>polarisation_saturation</code>, <code>amplifier_saturation</code>.</p><p>Distinguished by: interferometer as reference; shift the working range.</p></html>"));
  end SensorPolynomial;

  block SensorQuadCell "Saturation of a quadrant detector under a Gaussian spot"
    extends Interfaces.PositionFilter;
    parameter Real radius(unit="um", min = 0) "1/e^2 radius of the spot";
    parameter Real centre(unit="um") = 0 "Middle of the detector";
  equation
    y_um = centre + radius*sqrt(Constants.pi/8)*Functions.erf(sqrt(2)*(u_um - centre)/radius);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-45,-41},{8,12},{80,70},{62,59},{31,33},{-44,-40},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>sensor-quad-cell</code>. Saturation of a quadrant detector under a Gaussian spot.</p><p><code>y = centre + radius*sqrt(pi/8)*erf(sqrt(2)*(x - centre)/radius)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>radius</td><td>{position}</td><td>required</td><td>0</td><td></td><td>1/e^2 radius of the spot</td></tr><tr><td>centre</td><td>{position}</td><td>0</td><td></td><td></td><td>Middle of the detector</td></tr></table><p>Source: L. P. Salles, D. W. de Lima Monteiro, IEEE Sensors Journal 10 (2010) 286-293.</p><p>Effect: <code>sensor_nonlinearity</code>.</p><p>In the residual: a polynomial of the position, the same on both branches and at every rate.</p><p>Looks like: <code>asymmetry</code>, <code>polarisation_saturation</code>, <code>amplifier_saturation</code>.</p><p>Distinguished by: interferometer as reference; shift the working range.</p></html>"));
  end SensorQuadCell;

  block SensorNoise "Noise of the sensor: white, and 1/f below a corner"
    extends Interfaces.PositionFilter;
    parameter Real lowest(unit="Hz", min = 1e-09, max = 1000000.0) = 0.01 "Frequency below which the 1/f part levels off";
    parameter Real rms(unit="um", min = 0) "Standard deviation of the white part per internal step";
    parameter Real corner(unit="Hz", min = 0) = 0 "Frequency below which 1/f noise is stronger";
    parameter Integer elements(min = 1, max = 64) = 13 "Number of lags: 2*log10(1/(2*step*lowest)), rounded up";
    Interfaces.NoiseInput n "Independent normal number of each step, white part" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    Interfaces.NoiseInput drive "Another one, for the 1/f part" annotation(Placement(transformation(extent={{-40,-120},{0,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real apart = log(10)/2 "Distance of the poles";
    final parameter Real pole[elements](each unit="rad/s") = {2*Constants.pi*lowest*10^((i - 1)/2) for i in 1:elements} "Poles";
    final parameter Real weight[elements](each unit="um") =
      {rms*sqrt(2*Constants.pi*corner)*apart/Constants.pi/sqrt(pole[i]) for i in 1:elements} "Weight of each lag";
    final parameter Real beyond = 0.85/(exp(apart/2) - 1) "What the poles left out add to the last ones";
    discrete Real z[elements](each start = 0, each fixed = true, each unit="um") "Lags of the 1/f part";
    discrete Real m(start = 0, fixed = true, unit="um") "Noise of this step";
  equation
    when sample(0, step) then
      z = Functions.flicker(pole, weight, beyond, step, drive, pre(z));
      m = rms*n + weight[elements]*beyond*drive + sum(z);
    end when;
    y_um = u_um + m;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,4},{-72,-18},{-63,38},{-55,-12},{-46,-45},{-38,27},{-30,60},{-21,-33},{-13,8},{-4,-52},{4,18},{12,50},{21,-22},{29,-8},{38,42},{46,-60},{54,15},{63,30},{71,-38},{80,0}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>sensor-noise</code>. Noise of the sensor: white, and 1/f below a corner.</p><p><code>y = x + n; S(f) = A*(1 + corner/f); A = 2*rms^2*period</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>lowest` (structure)</td><td>Hz</td><td>0.01</td><td>0.000000001</td><td>1000000</td><td>Frequency below which the 1/f part levels off</td></tr><tr><td>rms</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Standard deviation of the white part per internal step</td></tr><tr><td>corner</td><td>Hz</td><td>0</td><td>0</td><td></td><td>Frequency below which 1/f noise is stronger</td></tr><tr><td>seed</td><td>1</td><td>1</td><td></td><td></td><td>Seed of the noise</td></tr></table><p>Source: N. J. Kasdin, Proc. IEEE 83 (1995) 802-827.</p><p>Effect: <code>sensor_noise</code>.</p><p>In the residual: the floor itself; does not repeat over periods.</p><p>Looks like: <code>floor_vibration</code>, <code>sensor_quantisation</code>.</p><p>Distinguished by: record at zero command.</p><p>In <code>p0-truth</code>: 0.060 % at most, 0.015 % rms.</p><p>In <code>p1-truth</code>: 1.8e-4 % at most, 3.1e-5 % rms.</p><p>In <code>p2-truth</code>: 0.050 % at most, 0.013 % rms.</p><p>In <code>p3-truth</code>: 0.009 % at most, 0.002 % rms.</p><p>In <code>p4-truth</code>: 0.228 % at most, 0.060 % rms.</p><p>In <code>evc-truth</code>: 0.181 % at most, 0.048 % rms.</p></html>"));
  end SensorNoise;

  block SensorDrift "Drift of the sensor's zero, as a random walk"
    extends Interfaces.PositionFilter;
    parameter Real per_hour(unit="um", min = 0) "Standard deviation after one hour";
    Interfaces.NoiseInput n "Independent normal number of each step" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real d(start = 0, fixed = true, unit="um") "Drift";
  equation
    when sample(0, step) then
      d = pre(d) + per_hour*sqrt(step/3600)*n;
    end when;
    y_um = u_um + d;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,3},{-72,-8},{-63,14},{-55,7},{-46,-20},{-38,-4},{-30,32},{-21,13},{-13,17},{-4,-14},{4,-4},{12,26},{21,13},{29,8},{38,33},{46,-3},{54,6},{63,24},{71,2},{80,2}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>sensor-drift</code>. Drift of the sensor's zero, as a random walk.</p><p><code>y = x + d; d[n] = d[n-1] + per_hour*sqrt(T/3600 s)*normal</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>per_hour</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Standard deviation after one hour</td></tr><tr><td>seed</td><td>1</td><td>1</td><td></td><td></td><td>Seed of the walk</td></tr></table><p>Source: A. J. Fleming, Sensors and Actuators A 190 (2013) 106-126.</p><p>Effect: <code>thermal_drift</code>.</p><p>In the residual: not coherent with the command; continues at zero command.</p><p>Looks like: <code>creep</code>, <code>self_heating</code>.</p><p>Distinguished by: record at zero command before and after.</p></html>"));
  end SensorDrift;

  block MainsHum "Hum of the mains and its harmonics"
    extends Interfaces.PositionFilter;
    parameter Integer harmonics(min = 1, max = 64) "Number of harmonics, the first being the mains";
    parameter Real amplitude[harmonics](each unit="um") "Amplitude of each harmonic";
    parameter Real phase[harmonics](each unit="rad") "Phase of each harmonic at time 0";
    parameter Real frequency(unit="Hz", min = 0) = 50 "Frequency of the mains";
  equation
    y_um = u_um + sum(amplitude[k]*sin(2*Constants.pi*k*frequency*time + phase[k]) for k in 1:harmonics);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,45},{-74,68},{-72,70},{-68,66},{-54,23},{-39,-6},{-26,-60},{-21,-70},{-17,-67},{-14,-53},{0,45},{7,69},{9,70},{12,66},{26,23},{40,-4},{54,-59},{59,-70},{63,-67},{67,-51},{80,43}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>mains-hum</code>. Hum of the mains and its harmonics.</p><p><code>y = x + sum(amplitude[k]*sin(2*pi*k*frequency*t + phase[k]))</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>harmonics` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of harmonics, the first being the mains</td></tr><tr><td>amplitude</td><td>{position}</td><td>required</td><td></td><td></td><td>Amplitude of each harmonic</td></tr><tr><td>phase</td><td>rad</td><td>required</td><td></td><td></td><td>Phase of each harmonic at time 0</td></tr><tr><td>frequency</td><td>Hz</td><td>50</td><td>0</td><td></td><td>Frequency of the mains</td></tr></table><p>Source: sum of sines.</p><p>Effect: <code>mains_hum</code>.</p><p>In the residual: lines at 50, 100, 150 Hz (60, 120, 180 Hz), present at zero command.</p><p>Looks like: <code>periodic_disturbance</code>, <code>extra_mode</code>.</p><p>Distinguished by: record at zero command; change the supply.</p><p>In <code>p0-truth</code>: 0.030 % at most, 0.012 % rms.</p></html>"));
  end MainsHum;

  block Crosstalk "Electrical feed-through from the command to the reading"
    extends Interfaces.PositionFilter;
    parameter Real gain(unit="um/V") = 0 "Reading per command";
    parameter Real rate_gain(unit="um.s/V") = 0 "Reading per rate of the command";
    Interfaces.CommandInput command "Command of the axis" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
    discrete Real last(start = 0, fixed = true, unit="V") "Command at the last sample";
    discrete Real change(start = 0, fixed = true, unit="V/s") "Rate of the command, by backward difference";
  equation
    when sample(0, step) then
      on = true;
      last = command;
      change = if pre(on) then (command - pre(last))/step else 0;
    end when;
    y_um = u_um + gain*command + rate_gain*change;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{8,-15},{80,70},{80,29},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>crosstalk</code>. Electrical feed-through from the command to the reading.</p><p><code>y = x + gain*u + rate_gain*u'</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>{position}/{command}</td><td>0</td><td></td><td></td><td>Reading per command</td></tr><tr><td>rate_gain</td><td>{position}.s/{command}</td><td>0</td><td></td><td></td><td>Reading per rate of the command</td></tr></table><p>Source: H. W. Ott, Electromagnetic Compatibility Engineering, Wiley 2009, ch. 2.</p><p>Effect: <code>crosstalk</code>.</p><p>In the residual: prompt, before the mechanics can move; rises with frequency.</p><p>Looks like: <code>cross_coupling</code>, <code>delay</code>.</p><p>Distinguished by: fix the stage mechanically and drive it.</p></html>"));
  end Crosstalk;

  block SensorQuantisation "Resolution of the reading's converter"
    extends Interfaces.PositionFilter;
    parameter Real resolution(unit="um", min = 0) "Step of the converter: range over 2^bits";
    parameter Real phase(unit="1") = 0 "Place of the codes between two multiples of the resolution";
  equation
    y_um = resolution*(Functions.round(u_um/resolution - phase) + phase);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-67,-70},{-67,-47},{-40,-47},{-40,-23},{-13,-23},{-13,0},{13,0},{13,23},{40,23},{40,47},{67,47},{67,70},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>sensor-quantisation</code>. Resolution of the reading's converter.</p><p><code>y = resolution*(round(x/resolution - phase) + phase)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>resolution</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Step of the converter: range over 2^bits</td></tr><tr><td>phase</td><td>1</td><td>0</td><td></td><td></td><td>Place of the codes between two multiples of the resolution</td></tr></table><p>Source: B. Widrow, I. Kollar, Quantization Noise, Cambridge University Press 2008.</p><p>Effect: <code>sensor_quantisation</code>.</p><p>In the residual: uniform noise of variance q^2/12.</p><p>Looks like: <code>sensor_noise</code>.</p><p>Distinguished by: histogram of the reading.</p><p>In <code>p0-truth</code>: 0.015 % at most, 0.009 % rms.</p></html>"));
  end SensorQuantisation;
  annotation(Documentation(info="<html><p>Position sensor and its conditioning.</p></html>"));
end Sensors;

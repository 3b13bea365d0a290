within Piezoloop;
package Sensors "Position sensor and its conditioning"
  block SensorLag "First-order bandwidth of the sensor and its filter"
    extends Interfaces.PositionFilter;
    parameter Real bandwidth(unit="Hz", min = 0) "Frequency at which the reading has fallen by 3 dB";
  initial equation
    der(y_um) = 0;
  equation
    der(y_um)/(2*Constants.pi*bandwidth) + y_um = u_um;
    annotation(Documentation(info="<html><p>Component <code>sensor-lag</code>:</p><p><code>y'/(2*pi*bandwidth) + y = x</code></p></html>"));
  end SensorLag;

  block SensorSecondOrder "Second-order bandwidth of the sensor and its filter"
    extends Interfaces.PositionFilter;
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency";
    parameter Real damping(unit="1", min = 0) = 0.707 "Damping ratio; 0.707 is flat";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real v(unit="um") "Rate of y over w";
  initial equation
    der(y_um) = 0;
    der(v) = 0;
  equation
    der(y_um) = w*v;
    der(v) = w*(u_um - y_um - 2*damping*v);
    annotation(Documentation(info="<html><p>Component <code>sensor-second-order</code>:</p><p><code>y'' + 2*damping*w*y' + w^2*y = w^2*x; w = 2*pi*frequency</code></p></html>"));
  end SensorSecondOrder;

  block SensorButterworth "Butterworth low-pass of the sensor, orders 1 to 8"
    extends Interfaces.PositionFilter;
    parameter Integer order(min = 1, max = 8) = 2 "Order of the filter";
    parameter Real bandwidth(unit="Hz", min = 0) "Frequency at which the reading has fallen by 3 dB";
  protected
    final parameter Integer pairs = div(order, 2) "Number of pairs of poles";
    final parameter Real w(unit="rad/s") = 2*Constants.pi*bandwidth "Angular frequency of the bandwidth";
    Real first(unit="um") "Behind the real pole of an odd order";
    Real s[pairs + 1](each unit="um") "Signal in front of and behind each pair";
    Real v[pairs](each unit="um") "Rate behind each pair over w";
  initial equation
    if mod(order, 2) == 1 then
      der(first) = 0;
    end if;
    for i in 1:pairs loop
      der(s[i + 1]) = 0;
      der(v[i]) = 0;
    end for;
  equation
    if mod(order, 2) == 1 then
      der(first) = w*(u_um - first);
    else
      first = u_um;
    end if;
    s[1] = first;
    for i in 1:pairs loop
      der(s[i + 1]) = w*v[i];
      der(v[i]) = w*(s[i] - s[i + 1] - 2*sin(Constants.pi*(2*i - 1)/(2*order))*v[i]);
    end for;
    y_um = s[pairs + 1];
    annotation(Documentation(info="<html><p>Component <code>sensor-butterworth</code>:</p><p><code>|G(j*2*pi*f)|^2 = 1/(1 + (f/bandwidth)^(2*order))</code></p></html>"));
  end SensorButterworth;

  block SensorScale "Gain and offset of the sensor"
    extends Interfaces.PositionFilter;
    parameter Real gain(unit="1") = 1 "Reading per position";
    parameter Real offset(unit="um") = 0 "Reading at position 0";
  equation
    y_um = gain*u_um + offset;
    annotation(Documentation(info="<html><p>Component <code>sensor-scale</code>:</p><p><code>y = gain*x + offset</code></p></html>"));
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
    annotation(Documentation(info="<html><p>Component <code>sensor-polynomial</code>:</p><p><code>y = x + half_range*(quadratic*xi^2 + cubic*xi^3); xi = (x - centre)/half_range</code></p></html>"));
  end SensorPolynomial;

  block SensorQuadCell "Saturation of a quadrant detector under a Gaussian spot"
    extends Interfaces.PositionFilter;
    parameter Real radius(unit="um", min = 0) "1/e^2 radius of the spot";
    parameter Real centre(unit="um") = 0 "Middle of the detector";
  equation
    y_um = centre + radius*sqrt(Constants.pi/8)*Functions.erf(sqrt(2)*(u_um - centre)/radius);
    annotation(Documentation(info="<html><p>Component <code>sensor-quad-cell</code>:</p><p><code>y = centre + radius*sqrt(pi/8)*erf(sqrt(2)*(x - centre)/radius)</code></p></html>"));
  end SensorQuadCell;

  block SensorNoise "Noise of the sensor: white, and 1/f below a corner"
    extends Interfaces.PositionFilter;
    parameter Real lowest(unit="Hz", min = 1e-09, max = 1000000.0) = 0.01 "Frequency below which the 1/f part levels off";
    parameter Real rms(unit="um", min = 0) "Standard deviation of the white part per internal step";
    parameter Real corner(unit="Hz", min = 0) = 0 "Frequency below which 1/f noise is stronger";
    parameter Integer elements(min = 1, max = 64) = 13 "Number of lags: 2*log10(1/(2*step*lowest)), rounded up";
    Interfaces.NoiseInput n "Independent normal number of each step, white part";
    Interfaces.NoiseInput drive "Another one, for the 1/f part";
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
    annotation(Documentation(info="<html><p>Component <code>sensor-noise</code>:</p><p><code>y = x + n; S(f) = A*(1 + corner/f); A = 2*rms^2*period</code></p></html>"));
  end SensorNoise;

  block SensorDrift "Drift of the sensor's zero, as a random walk"
    extends Interfaces.PositionFilter;
    parameter Real per_hour(unit="um", min = 0) "Standard deviation after one hour";
    Interfaces.NoiseInput n "Independent normal number of each step";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real d(start = 0, fixed = true, unit="um") "Drift";
  equation
    when sample(0, step) then
      d = pre(d) + per_hour*sqrt(step/3600)*n;
    end when;
    y_um = u_um + d;
    annotation(Documentation(info="<html><p>Component <code>sensor-drift</code>:</p><p><code>y = x + d; d[n] = d[n-1] + per_hour*sqrt(T/3600 s)*normal</code></p></html>"));
  end SensorDrift;

  block MainsHum "Hum of the mains and its harmonics"
    extends Interfaces.PositionFilter;
    parameter Integer harmonics(min = 1, max = 64) "Number of harmonics, the first being the mains";
    parameter Real amplitude[harmonics](each unit="um") "Amplitude of each harmonic";
    parameter Real phase[harmonics](each unit="rad") "Phase of each harmonic at time 0";
    parameter Real frequency(unit="Hz", min = 0) = 50 "Frequency of the mains";
  equation
    y_um = u_um + sum(amplitude[k]*sin(2*Constants.pi*k*frequency*time + phase[k]) for k in 1:harmonics);
    annotation(Documentation(info="<html><p>Component <code>mains-hum</code>:</p><p><code>y = x + sum(amplitude[k]*sin(2*pi*k*frequency*t + phase[k]))</code></p></html>"));
  end MainsHum;

  block Crosstalk "Electrical feed-through from the command to the reading"
    extends Interfaces.PositionFilter;
    parameter Real gain(unit="um/V") = 0 "Reading per command";
    parameter Real rate_gain(unit="um.s/V") = 0 "Reading per rate of the command";
    Interfaces.CommandInput command "Command of the axis";
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
    annotation(Documentation(info="<html><p>Component <code>crosstalk</code>:</p><p><code>y = x + gain*u + rate_gain*u'</code></p></html>"));
  end Crosstalk;

  block SensorQuantisation "Resolution of the reading's converter"
    extends Interfaces.PositionFilter;
    parameter Real resolution(unit="um", min = 0) "Step of the converter: range over 2^bits";
  equation
    y_um = resolution*Functions.round(u_um/resolution);
    annotation(Documentation(info="<html><p>Component <code>sensor-quantisation</code>:</p><p><code>y = resolution*round(x/resolution)</code></p></html>"));
  end SensorQuantisation;
end Sensors;

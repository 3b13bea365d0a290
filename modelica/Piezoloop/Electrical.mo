within Piezoloop;
package Electrical "Amplifier and electrical port"
  block AmplifierLag "First-order bandwidth of the amplifier into the actuator's capacitance"
    extends Interfaces.CommandFilter;
    parameter Real bandwidth(unit="Hz", min = 0) "Frequency at which the gain has fallen by 3 dB";
    parameter Real gain(unit="1") = 1 "Gain at low frequency";
  initial equation
    der(y) = 0;
  equation
    der(y)/(2*Constants.pi*bandwidth) + y = gain*u;
    annotation(Documentation(info="<html><p>Component <code>amplifier-lag</code>:</p><p><code>v'/(2*pi*bandwidth) + v = gain*u</code></p></html>"));
  end AmplifierLag;

  block AmplifierSecondOrder "Second-order bandwidth of the amplifier into the actuator's capacitance"
    extends Interfaces.CommandFilter;
    parameter Real frequency(unit="Hz", min = 0) "Natural frequency";
    parameter Real damping(unit="1", min = 0) "Damping ratio; 0.707 is flat";
    parameter Real gain(unit="1") = 1 "Gain at low frequency";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    Real v(unit="V") "Rate of y over w";
  initial equation
    der(y) = 0;
    der(v) = 0;
  equation
    der(y) = w*v;
    der(v) = w*(gain*u - y - 2*damping*v);
    annotation(Documentation(info="<html><p>Component <code>amplifier-second-order</code>:</p><p><code>v'' + 2*damping*w*v' + w^2*v = w^2*gain*u; w = 2*pi*frequency</code></p></html>"));
  end AmplifierSecondOrder;

  block AmplifierRc "Output resistance and current limit into the capacitance of a moving actuator"
    extends Interfaces.CommandFilter;
    parameter Real resistance(unit="Ohm", min = 0) "Output resistance";
    parameter Real capacitance(unit="F", min = 0) "Capacitance of the actuator";
    parameter Real current(unit="A", min = 0) "Greatest current";
    parameter Real gain(unit="1") = 1 "Gain at low frequency";
    parameter Real transduction(unit="C/um") = 0 "Charge per displacement; 0 for none";
    Interfaces.PositionInput displacement "Displacement behind the mechanics";
  protected
    Real displacement_um(unit="um") = displacement/Constants.um "displacement in um";
    Real i(unit="A") "Current into the actuator";
  initial equation
    y = gain*u;
  equation
    i = min(max((gain*u - y)/resistance, -current), current);
    capacitance*der(y) + transduction*der(displacement_um) = i;
    annotation(Documentation(info="<html><p>Component <code>amplifier-rc</code>:</p><p><code>capacitance*v' + transduction*x' = i; i = min(max((gain*u - v)/resistance, -current), current)</code></p></html>"));
  end AmplifierRc;

  block AmplifierSlew "Current limit of the amplifier, as a limit of the slope"
    extends Interfaces.CommandFilter;
    parameter Real rate(unit="V/s", min = 0) "Greatest slope";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real v(start = 0, fixed = true, unit="V") "Voltage at the end of the step";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      v = if pre(on) then pre(v) + min(max(u - pre(v), -rate*step), rate*step) else u;
    end when;
    y = v;
    annotation(Documentation(info="<html><p>Component <code>amplifier-slew</code>:</p><p><code>v' = min(max((u - v)/T, -rate), rate)</code></p></html>"));
  end AmplifierSlew;

  block AmplifierFoldback "Average current limit of the amplifier: it falls back after fast driving for a while"
    extends Interfaces.CommandFilter;
    parameter Real continuous(unit="A", min = 0) "Greatest rms current";
    parameter Real peak(unit="A", min = 0) "Greatest current at any time";
    parameter Real capacitance(unit="C/V", min = 0) "Capacitance of the actuator";
    parameter Real time_constant(unit="s", min = 0) = 1 "Averaging time of the rms current";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real v(start = 0, fixed = true, unit="V") "Voltage at the end of the step";
    discrete Real q(start = 0, fixed = true, unit="A2") "Mean square of the current";
    discrete Real most(start = 0, fixed = true, unit="V") "Greatest way in this step";
    discrete Real way(start = 0, fixed = true, unit="V") "Way of this step";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      most = step/capacitance*(if pre(q) <= continuous^2 then peak else continuous);
      way = if pre(on) then min(max(u - pre(v), -most), most) else 0;
      v = if pre(on) then pre(v) + way else u;
      q = pre(q) + (1 - exp(-step/time_constant))*((capacitance*way/step)^2 - pre(q));
    end when;
    y = v;
    annotation(Documentation(info="<html><p>Component <code>amplifier-foldback</code>:</p><p><code>|v'| &lt;= i/capacitance; i = peak while q &lt;= continuous^2, else continuous; time_constant*q' = (capacitance*v')^2 - q</code></p></html>"));
  end AmplifierFoldback;

  block AmplifierClamp "Voltage limits of the amplifier, hard or soft"
    extends Interfaces.CommandFilter;
    parameter Real low(unit="V") "Least voltage";
    parameter Real high(unit="V") "Greatest voltage";
    parameter Real softness(unit="V", min = 0) = 0 "Half width of the bend at each limit";
  protected
    Real above(unit="V") "What the upper bend takes away";
    Real below(unit="V") "What the lower bend adds";
  equation
    above = Functions.excess(u - high, softness);
    below = Functions.excess(low - u, softness);
    y = u - above + below;
    annotation(Documentation(info="<html><p>Component <code>amplifier-clamp</code>:</p><p><code>v = min(max(u, low), high), with a parabola within softness of a limit</code></p></html>"));
  end AmplifierClamp;

  block AmplifierNonlinearity "Offset and integral nonlinearity of converter and amplifier"
    extends Interfaces.CommandFilter;
    parameter Real offset(unit="V") = 0 "Voltage at zero command";
    parameter Real quadratic(unit="1") = 0 "Quadratic deviation at the end of the range";
    parameter Real cubic(unit="1") = 0 "Cubic deviation at the end of the range";
    parameter Real centre(unit="V") "Middle of the range";
    parameter Real half_range(unit="V", min = 0) "Half of the range";
  protected
    Real xi(unit="1") "Place in the range, -1 to 1";
  equation
    xi = (u - centre)/half_range;
    y = u + offset + half_range*(quadratic*xi^2 + cubic*xi^3);
    annotation(Documentation(info="<html><p>Component <code>amplifier-nonlinearity</code>:</p><p><code>v = u + offset + half_range*(quadratic*xi^2 + cubic*xi^3); xi = (u - centre)/half_range</code></p></html>"));
  end AmplifierNonlinearity;

  block PiezoCharge "Electrical port of the actuator: voltage, charge and current as outputs"
    extends Interfaces.CommandFilter;
    parameter Real capacitance(unit="C/V", min = 0) "Capacitance at constant length";
    parameter Real transduction(unit="C/um") = 0 "Charge per displacement";
    Interfaces.PositionInput displacement "Displacement behind the mechanics";
    Interfaces.CommandOutput voltage "Voltage at the actuator";
    output Real charge(unit="C", quantity="ElectricCharge") "Charge on the actuator";
    output Real current(unit="A", quantity="ElectricCurrent") "Current into the actuator, mean of the step";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    Real displacement_um(unit="um") = displacement/Constants.um "displacement in um";
    discrete Real q(start = 0, fixed = true, unit="C") "Charge at the last sample";
    discrete Real i(start = 0, fixed = true, unit="A") "Mean current of the last step";
    discrete Boolean on(start = false, fixed = true) "The first sample is past";
  equation
    when sample(0, step) then
      on = true;
      q = capacitance*u + transduction*displacement_um;
      i = if pre(on) then (q - pre(q))/step else 0;
    end when;
    y = u;
    voltage = u;
    charge = q;
    current = i;
    annotation(Documentation(info="<html><p>Component <code>piezo-charge</code>:</p><p><code>q = capacitance*v + transduction*x; i = dq/dt</code></p></html>"));
  end PiezoCharge;
end Electrical;

within Piezoloop.Examples;
package Electrical "Examples of single blocks: Electrical"
  extends Icons.ExamplesPackage;

  model AmplifierLag "First-order bandwidth of the amplifier into the actuator's capacitance"
    extends Icons.Example;
    Piezoloop.Electrical.AmplifierLag device(bandwidth = 400.0, gain = 1.1) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Electrical.AmplifierLag as it is compared with the FMU.</p></html>"));
  end AmplifierLag;

  model AmplifierSecondOrder "Second-order bandwidth of the amplifier into the actuator's capacitance"
    extends Icons.Example;
    Piezoloop.Electrical.AmplifierSecondOrder device(frequency = 500.0, damping = 0.6, gain = 0.9) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Electrical.AmplifierSecondOrder as it is compared with the FMU.</p></html>"));
  end AmplifierSecondOrder;

  model AmplifierRc "Output resistance and current limit into the capacitance of a moving actuator"
    extends Icons.Example;
    Piezoloop.Electrical.AmplifierRc device(resistance = 50.0, capacitance = 5e-06, current = 0.1) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Constant displacement(k = 0.0) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(displacement.y, device.displacement) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Electrical.AmplifierRc as it is compared with the FMU.</p></html>"));
  end AmplifierRc;

  model AmplifierSlew "Current limit of the amplifier, as a limit of the slope"
    extends Icons.Example;
    Piezoloop.Electrical.AmplifierSlew device(rate = 9000.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Electrical.AmplifierSlew as it is compared with the FMU.</p></html>"));
  end AmplifierSlew;

  model AmplifierFoldback "Average current limit of the amplifier, which acts after sustained fast driving"
    extends Icons.Example;
    Piezoloop.Electrical.AmplifierFoldback device(continuous = 0.03, peak = 0.08, capacitance = 5e-06, time_constant = 0.01, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Electrical.AmplifierFoldback as it is compared with the FMU.</p></html>"));
  end AmplifierFoldback;

  model AmplifierClamp "Voltage limits of the amplifier, hard or soft"
    extends Icons.Example;
    Piezoloop.Electrical.AmplifierClamp device(low = 5.0, high = 80.0, softness = 4.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Electrical.AmplifierClamp as it is compared with the FMU.</p></html>"));
  end AmplifierClamp;

  model AmplifierNonlinearity "Offset and integral nonlinearity of converter and amplifier"
    extends Icons.Example;
    Piezoloop.Electrical.AmplifierNonlinearity device(offset = 0.1, quadratic = 0.01, cubic = -0.02, centre = 50.0, half_range = 60.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Electrical.AmplifierNonlinearity as it is compared with the FMU.</p></html>"));
  end AmplifierNonlinearity;

  model PiezoCharge "Electrical port of the actuator: voltage, charge and current as outputs"
    extends Icons.Example;
    Piezoloop.Electrical.PiezoCharge device(capacitance = 5e-06, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Constant displacement(k = 0.0) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(displacement.y, device.displacement) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Electrical.PiezoCharge as it is compared with the FMU.</p></html>"));
  end PiezoCharge;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Electrical;

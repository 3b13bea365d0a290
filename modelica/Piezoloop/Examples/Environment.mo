within Piezoloop.Examples;
package Environment "Examples of single blocks: Environment"
  extends Icons.ExamplesPackage;

  model ThermalDrift "Thermal growth of the structure: steady, settling, and in proportion to a given temperature"
    extends Icons.Example;
    Piezoloop.Blocks.Environment.ThermalDrift device(rate = 0.5, settling = 0.3, time_constant = 0.02, expansion = 0.1, temperature_change = 2.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Environment.ThermalDrift as it is compared with the FMU.</p></html>"));
  end ThermalDrift;

  model ThermalExpansion "Thermal growth of the structure with the temperature of the surroundings"
    extends Icons.Example;
    Piezoloop.Blocks.Environment.ThermalExpansion device(expansion = 0.2, time_constant = 0.01) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave temperature(offset = 273.15, scale = 0.1, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(temperature.y, device.temperature) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Environment.ThermalExpansion as it is compared with the FMU.</p></html>"));
  end ThermalExpansion;

  model Disturbance "External disturbance of the position, for example played back from a log"
    extends Icons.Example;
    Piezoloop.Blocks.Environment.Disturbance device(gain = 0.8) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave disturbance(scale = 1e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(disturbance.y, device.disturbance) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Environment.Disturbance as it is compared with the FMU.</p></html>"));
  end Disturbance;

  model FloorVibration "Floor vibration: noise through a mode"
    extends Icons.Example;
    Piezoloop.Blocks.Environment.FloorVibration device(rms = 0.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Constant n(k = 0.0) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(n.y, device.n) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Environment.FloorVibration as it is compared with the FMU.</p></html>"));
  end FloorVibration;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Environment;

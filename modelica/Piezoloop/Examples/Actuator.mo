within Piezoloop.Examples;
package Actuator "Examples of single blocks: Actuator"
  extends Icons.ExamplesPackage;

  model PolarisationSaturation "Saturation of the strain towards both ends of the voltage range"
    extends Icons.Example;
    Piezoloop.Blocks.Actuator.PolarisationSaturation device(flattening = 0.05, centre = 50.0, half_range = 45.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Actuator.PolarisationSaturation as it is compared with the FMU.</p></html>"));
  end PolarisationSaturation;

  model ActuatorGain "Linear actuator: position proportional to command"
    extends Icons.Example;
    Piezoloop.Blocks.Actuator.ActuatorGain device(gain = 0.12, offset = 0.4) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Actuator.ActuatorGain as it is compared with the FMU.</p></html>"));
  end ActuatorGain;

  model ActuatorTemperature "Temperature dependence of the actuator's gain"
    extends Icons.Example;
    Piezoloop.Blocks.Actuator.ActuatorTemperature device(coefficient = 0.001, temperature = 35.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Actuator.ActuatorTemperature as it is compared with the FMU.</p></html>"));
  end ActuatorTemperature;

  model ActuatorAgeing "Ageing of the actuator: its gain falls with the logarithm of time"
    extends Icons.Example;
    Piezoloop.Blocks.Actuator.ActuatorAgeing device(per_decade = 0.03, age = 0.01) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Actuator.ActuatorAgeing as it is compared with the FMU.</p></html>"));
  end ActuatorAgeing;

  model SelfHeating "Self-heating of the actuator by its losses, which changes gain and length"
    extends Icons.Example;
    Piezoloop.Blocks.Actuator.SelfHeating device(loss = 0.05, capacitance = 5e-06, resistance = 40.0, time_constant = 0.02, coefficient = 0.01, growth = 0.05, amplification = 2.0, averaging = 0.05, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave command(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(command.y, device.command) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Actuator.SelfHeating as it is compared with the FMU.</p></html>"));
  end SelfHeating;

  model ThermalPort "Thermal port of the actuator: temperature from outside, heat of its losses as output"
    extends Icons.Example;
    Piezoloop.Blocks.Actuator.ThermalPort device(growth = 0.05, loss = 0.05, capacitance = 5e-06, coefficient = 0.01, averaging = 0.05, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave actuator_temperature(offset = 273.15, scale = 0.1, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave voltage(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(actuator_temperature.y, device.actuator_temperature) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(voltage.y, device.voltage) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Actuator.ThermalPort as it is compared with the FMU.</p></html>"));
  end ThermalPort;

  model Remanence "Remanence of an unknown past, which fades until the command has wiped it out"
    extends Icons.Example;
    Piezoloop.Blocks.Actuator.Remanence device(remanence = 0.7, reach = 60.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave command(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(command.y, device.command) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Actuator.Remanence as it is compared with the FMU.</p></html>"));
  end Remanence;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Actuator;

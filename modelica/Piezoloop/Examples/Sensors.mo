within Piezoloop.Examples;
package Sensors "Examples of single blocks: Sensors"
  extends Icons.ExamplesPackage;

  model SensorLag "First-order bandwidth of the sensor and its filter"
    extends Icons.Example;
    Piezoloop.Sensors.SensorLag device(bandwidth = 700.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.SensorLag as it is compared with the FMU.</p></html>"));
  end SensorLag;

  model SensorSecondOrder "Second-order bandwidth of the sensor and its filter"
    extends Icons.Example;
    Piezoloop.Sensors.SensorSecondOrder device(frequency = 800.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.SensorSecondOrder as it is compared with the FMU.</p></html>"));
  end SensorSecondOrder;

  model SensorButterworth "Butterworth low-pass of the sensor, orders 1 to 8"
    extends Icons.Example;
    Piezoloop.Sensors.SensorButterworth device(bandwidth = 600.0, order = 5) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.SensorButterworth as it is compared with the FMU.</p></html>"));
  end SensorButterworth;

  model SensorScale "Gain and offset of the sensor"
    extends Icons.Example;
    Piezoloop.Sensors.SensorScale device(gain = 1.02, offset = 0.1) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.SensorScale as it is compared with the FMU.</p></html>"));
  end SensorScale;

  model SensorPolynomial "Static nonlinearity of the sensor, quadratic and cubic"
    extends Icons.Example;
    Piezoloop.Sensors.SensorPolynomial device(quadratic = 0.01, cubic = 0.02, centre = 5.0, half_range = 6.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.SensorPolynomial as it is compared with the FMU.</p></html>"));
  end SensorPolynomial;

  model SensorQuadCell "Saturation of a quadrant detector under a Gaussian spot"
    extends Icons.Example;
    Piezoloop.Sensors.SensorQuadCell device(radius = 9.0, centre = 4.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.SensorQuadCell as it is compared with the FMU.</p></html>"));
  end SensorQuadCell;

  model SensorNoise "Noise of the sensor: white, and 1/f below a corner"
    extends Icons.Example;
    Piezoloop.Sensors.SensorNoise device(rms = 0.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Constant n(k = 0.0) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Constant drive(k = 0.0) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(n.y, device.n) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(drive.y, device.drive) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.SensorNoise as it is compared with the FMU.</p></html>"));
  end SensorNoise;

  model SensorDrift "Drift of the sensor's zero, as a random walk"
    extends Icons.Example;
    Piezoloop.Sensors.SensorDrift device(per_hour = 0.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Constant n(k = 0.0) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(n.y, device.n) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.SensorDrift as it is compared with the FMU.</p></html>"));
  end SensorDrift;

  model MainsHum "Hum of the mains and its harmonics"
    extends Icons.Example;
    Piezoloop.Sensors.MainsHum device(amplitude = {0.3, 0.1}, phase = {0.4, 1.0}, harmonics = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.MainsHum as it is compared with the FMU.</p></html>"));
  end MainsHum;

  model Crosstalk "Electrical feed-through from the command to the reading"
    extends Icons.Example;
    Piezoloop.Sensors.Crosstalk device(gain = 0.01, rate_gain = 1e-05, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave command(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(command.y, device.command) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.Crosstalk as it is compared with the FMU.</p></html>"));
  end Crosstalk;

  model SensorQuantisation "Resolution of the reading's converter"
    extends Icons.Example;
    Piezoloop.Sensors.SensorQuantisation device(resolution = 0.037, phase = -0.2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Sensors.SensorQuantisation as it is compared with the FMU.</p></html>"));
  end SensorQuantisation;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Sensors;

within Piezoloop.Examples;
package Mechanics "Examples of single blocks: Mechanics"
  extends Icons.ExamplesPackage;

  model LoadForce "External load force through the actuator's stiffness, before a mode"
    extends Icons.Example;
    Piezoloop.Mechanics.LoadForce device(stiffness = 40.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave force(scale = 0.5, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(force.y, device.force) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.LoadForce as it is compared with the FMU.</p></html>"));
  end LoadForce;

  model Mode "Second-order mode with exact discretisation at any step and any damping"
    extends Icons.Example;
    Piezoloop.Mechanics.Mode device(frequency = 300.0, damping = 0.05, gain = 1.2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.Mode as it is compared with the FMU.</p></html>"));
  end Mode;

  model ModePair "Two second-order modes side by side"
    extends Icons.Example;
    Piezoloop.Mechanics.ModePair device(frequency = 300.0, damping = 0.05, second_frequency = 450.0, second_damping = 0.03, share = -0.2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.ModePair as it is compared with the FMU.</p></html>"));
  end ModePair;

  model CollocatedMode "Resonance with its antiresonance"
    extends Icons.Example;
    Piezoloop.Mechanics.CollocatedMode device(frequency = 300.0, damping = 0.05, zero_frequency = 220.0, zero_damping = 0.04) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.CollocatedMode as it is compared with the FMU.</p></html>"));
  end CollocatedMode;

  model LoadedMode "Second-order mode under a payload mass and an external spring"
    extends Icons.Example;
    Piezoloop.Mechanics.LoadedMode device(frequency = 300.0, damping = 0.05, mass = 0.2, payload = 0.1, external_stiffness = 100000.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.LoadedMode as it is compared with the FMU.</p></html>"));
  end LoadedMode;

  model Duffing "Mode whose stiffness grows with its deflection"
    extends Icons.Example;
    Piezoloop.Mechanics.Duffing device(frequency = 300.0, damping = 0.05, hardening = 0.05, reference = 4.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.Duffing as it is compared with the FMU.</p></html>"));
  end Duffing;

  model PositionStiffness "Mode whose stiffness depends on the position"
    extends Icons.Example;
    Piezoloop.Mechanics.PositionStiffness device(frequency = 300.0, damping = 0.05, linear = 0.05, quadratic = -0.03, centre = 5.0, half_range = 6.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.PositionStiffness as it is compared with the FMU.</p></html>"));
  end PositionStiffness;

  model Friction "Mode with LuGre friction"
    extends Icons.Example;
    Piezoloop.Mechanics.Friction device(frequency = 300.0, damping = 0.05, coulomb = 0.2, stiction = 0.3, presliding = 0.05, stribeck = 300.0) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.Friction as it is compared with the FMU.</p></html>"));
  end Friction;

  model NonlinearDamping "Mode with Coulomb friction and speed-dependent damping"
    extends Icons.Example;
    Piezoloop.Mechanics.NonlinearDamping device(frequency = 300.0, damping = 0.05, coulomb = 0.1, velocity = 60.0, growth = 2e-05) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.NonlinearDamping as it is compared with the FMU.</p></html>"));
  end NonlinearDamping;

  model Arx "Discrete transfer function (ARX model) at its own sample time"
    extends Icons.Example;
    Piezoloop.Mechanics.Arx device(sample_time = 0.0004, b = {0.276897, -0.540637, 0.263941}, a = {-2.72054, 2.45461, -0.733864}, numerator = 3, denominator = 3, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.Arx as it is compared with the FMU.</p></html>"));
  end Arx;

  model Backlash "Clearance, as a play of constant width"
    extends Icons.Example;
    Piezoloop.Mechanics.Backlash device(width = 0.8, bridge = 0.2, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.Backlash as it is compared with the FMU.</p></html>"));
  end Backlash;

  model CuttingForce "Cutting force once per ellipse, while the tool is in cut"
    extends Icons.Example;
    Piezoloop.Mechanics.CuttingForce device(amplitude = 0.5, frequency = 131.0, duty = 0.4, phase = 0.3) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.CuttingForce as it is compared with the FMU.</p></html>"));
  end CuttingForce;

  model Vibration "Vibration at fixed frequencies"
    extends Icons.Example;
    Piezoloop.Mechanics.Vibration device(frequency = {47.0, 133.0}, amplitude = {0.2, 0.1}, phase = {0.3, -1.0}, lines = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.Vibration as it is compared with the FMU.</p></html>"));
  end Vibration;

  model MechanicalPort "Mechanical port of the axis: position and velocity of its tip as outputs, in SI"
    extends Icons.Example;
    Piezoloop.Mechanics.MechanicalPort device(step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Mechanics.MechanicalPort as it is compared with the FMU.</p></html>"));
  end MechanicalPort;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Mechanics;

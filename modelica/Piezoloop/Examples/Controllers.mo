within Piezoloop.Examples;
package Controllers "Examples of single blocks: Controllers"
  extends Icons.ExamplesPackage;

  model ReferenceLead "Adds the first and second derivative of the reference, for lags and a mode"
    extends Icons.Example;
    Piezoloop.Controllers.ReferenceLead device(lag = 0.0005, inertia = 2e-07, limit = 1.5, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.ReferenceLead as it is compared with the FMU.</p></html>"));
  end ReferenceLead;

  model FeedforwardGain "Linear feedforward: command proportional to the reference position"
    extends Icons.Example;
    Piezoloop.Controllers.FeedforwardGain device(gain = 12.0, offset = 0.3) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.FeedforwardGain as it is compared with the FMU.</p></html>"));
  end FeedforwardGain;

  model ReferenceCurve "Curve through points before the feedforward, for a static nonlinearity of the sensor"
    extends Icons.Example;
    Piezoloop.Controllers.ReferenceCurve device(at = {0.0, 2.0, 5.0, 9.0}, value = {0.2, 1.9, 5.3, 8.8}, points = 4) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.ReferenceCurve as it is compared with the FMU.</p></html>"));
  end ReferenceCurve;

  model CommandCurve "Curve through points behind the feedforward, for a static nonlinearity of the amplifier"
    extends Icons.Example;
    Piezoloop.Controllers.CommandCurve device(at = {0.0, 20.0, 50.0, 90.0}, value = {2.0, 19.0, 53.0, 88.0}, points = 4) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.CommandCurve as it is compared with the FMU.</p></html>"));
  end CommandCurve;

  model Pid "PID with feedforward, output and rate limits, anti-windup and bumpless enabling"
    extends Icons.Example;
    Piezoloop.Controllers.Pid device(kp = 3.0, ki = 900.0, kd = 0.001, output_min = 3.0, output_max = 90.0, derivative_filter = 0.0002, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave reference(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(reference.y, device.reference) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.Pid as it is compared with the FMU.</p></html>"));
  end Pid;

  model PidReversed "PID with feedforward, output and rate limits, anti-windup and bumpless enabling"
    extends Icons.Example;
    Piezoloop.Controllers.Pid device(kp = -3.0, ki = -900.0, kd = 0.001, output_min = 3.0, output_max = 90.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave reference(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(reference.y, device.reference) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.Pid as it is compared with the FMU.</p></html>"));
  end PidReversed;

  model PidSafe "PID with feedforward, output and rate limits, anti-windup and bumpless enabling"
    extends Icons.Example;
    Piezoloop.Controllers.Pid device(kp = 3.0, ki = 900.0, kd = 0.001, output_min = 3.0, output_max = 90.0, feedforward_gain = 0.9, rate_max = 20000.0, hold = 0.0, safe = 12.0, derivative_filter = 0.0002, tracking_time = 0.002, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave reference(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(reference.y, device.reference) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.Pid as it is compared with the FMU.</p></html>"));
  end PidSafe;

  model IncrementalPid "PID in incremental form with feedforward, output and rate limits, bumpless enabling"
    extends Icons.Example;
    Piezoloop.Controllers.IncrementalPid device(kp = 3.0, ki = 900.0, kd = 0.001, output_min = 3.0, output_max = 90.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave reference(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(reference.y, device.reference) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.IncrementalPid as it is compared with the FMU.</p></html>"));
  end IncrementalPid;

  model IncrementalPidSafe "PID in incremental form with feedforward, output and rate limits, bumpless enabling"
    extends Icons.Example;
    Piezoloop.Controllers.IncrementalPid device(kp = 3.0, ki = 900.0, kd = 0.001, output_min = 3.0, output_max = 90.0, feedforward_gain = 0.9, rate_max = 20000.0, hold = 0.0, safe = 12.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave reference(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(reference.y, device.reference) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.IncrementalPid as it is compared with the FMU.</p></html>"));
  end IncrementalPidSafe;

  model BoucWenFeedforward "Feedforward that uses a Bouc-Wen model itself, without an inverse"
    extends Icons.Example;
    Piezoloop.Controllers.BoucWenFeedforward device(gain = 0.08, beta = 0.04, gamma = 0.015, alpha = 0.3, lag = 0.0005, inertia = 2e-07, limit = 0.4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.BoucWenFeedforward as it is compared with the FMU.</p></html>"));
  end BoucWenFeedforward;

  model BoucWenFeedforwardBackwards "Feedforward that uses a Bouc-Wen model itself, without an inverse"
    extends Icons.Example;
    Piezoloop.Controllers.BoucWenFeedforward device(gain = 0.08, beta = 0.04, gamma = 0.015, alpha = 0.9, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.BoucWenFeedforward as it is compared with the FMU.</p></html>"));
  end BoucWenFeedforwardBackwards;

  model Notch "Notch filter against a resonance"
    extends Icons.Example;
    Piezoloop.Controllers.Notch device(frequency = 480.0, damping = 0.4, depth = 0.1, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.Notch as it is compared with the FMU.</p></html>"));
  end Notch;

  model ReferenceFilter "Second-order low-pass for the reference of both feedforward and feedback"
    extends Icons.Example;
    Piezoloop.Controllers.ReferenceFilter device(frequency = 200.0, damping = 0.8, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Types.Position command "Command of a law of gain 1 behind it";
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    command = device.y + device.reference - measured.y;
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.ReferenceFilter as it is compared with the FMU.</p></html>"));
  end ReferenceFilter;

  model ReferenceFilterCritical "Second-order low-pass for the reference of both feedforward and feedback"
    extends Icons.Example;
    Piezoloop.Controllers.ReferenceFilter device(frequency = 200.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Types.Position command "Command of a law of gain 1 behind it";
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    command = device.y + device.reference - measured.y;
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.ReferenceFilter as it is compared with the FMU.</p></html>"));
  end ReferenceFilterCritical;

  model ReferenceFilterSlow "Second-order low-pass for the reference of both feedforward and feedback"
    extends Icons.Example;
    Piezoloop.Controllers.ReferenceFilter device(frequency = 200.0, damping = 1.3, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Types.Position command "Command of a law of gain 1 behind it";
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    command = device.y + device.reference - measured.y;
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.ReferenceFilter as it is compared with the FMU.</p></html>"));
  end ReferenceFilterSlow;

  model ReferenceFilterWide "Second-order low-pass for the reference of both feedforward and feedback"
    extends Icons.Example;
    Piezoloop.Controllers.ReferenceFilter device(frequency = 5000.0, damping = 1.3, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Types.Position command "Command of a law of gain 1 behind it";
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    command = device.y + device.reference - measured.y;
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.ReferenceFilter as it is compared with the FMU.</p></html>"));
  end ReferenceFilterWide;

  model ReferencePreview "Preview of the reference: feedforward uses it at once, feedback later"
    extends Icons.Example;
    Piezoloop.Controllers.ReferencePreview device(preview = 0.00033, longest = 0.001, cells = 12, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Types.Position command "Command of a law of gain 1 behind it";
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    command = device.y + device.reference - measured.y;
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.ReferencePreview as it is compared with the FMU.</p></html>"));
  end ReferencePreview;

  model DisturbanceObserver "Estimates the machine's deviation from its model and subtracts it from the reference, before the inverse"
    extends Icons.Example;
    Piezoloop.Controllers.DisturbanceObserver device(bandwidth = 90.0, lag = 0.001, delay_ = 0.00024, longest = 0.001, limit = 1.3, cells = 12, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.DisturbanceObserver as it is compared with the FMU.</p></html>"));
  end DisturbanceObserver;

  model Repetitive "Repetitive (iterative learning) control of a periodic reference"
    extends Icons.Example;
    Piezoloop.Controllers.Repetitive device(cycle = 0.005, half = 4, gain = 3.0, lead = 0.0003, keep = 0.95, limit = 9.0, cells = 54, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave reference(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(reference.y, device.reference) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.Repetitive as it is compared with the FMU.</p></html>"));
  end Repetitive;

  model IntegralResonantControl "Integral resonant control: a low-pass of the position in positive feedback damps a resonance"
    extends Icons.Example;
    Piezoloop.Controllers.IntegralResonantControl device(gain = 6.0, frequency = 400.0, setpoint_weight = 0.3, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave reference(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(reference.y, device.reference) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.IntegralResonantControl as it is compared with the FMU.</p></html>"));
  end IntegralResonantControl;

  model PositivePositionFeedback "Positive position feedback: a resonant low-pass of the position damps a resonance"
    extends Icons.Example;
    Piezoloop.Controllers.PositivePositionFeedback device(gain = 6.0, frequency = 700.0, damping = 0.4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave reference(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(reference.y, device.reference) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.PositivePositionFeedback as it is compared with the FMU.</p></html>"));
  end PositivePositionFeedback;

  model NonMinimumPhaseDamping "Non-minimum-phase damping: feedback of the position through an all-pass, with constant gain and shifted phase"
    extends Icons.Example;
    Piezoloop.Controllers.NonMinimumPhaseDamping device(gain = 6.0, frequency = 500.0, setpoint_weight = 0.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 0.64, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave reference(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Enable enable(off = 0.007200000000000001, on = 0.012100000000000001, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(reference.y, device.reference) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured.y, device.measured) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(enable.y, device.enable) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.NonMinimumPhaseDamping as it is compared with the FMU.</p></html>"));
  end NonMinimumPhaseDamping;

  model JacobianCoordinator "From the coordinates of all sensors to the motions of all axes, through the inverse Jacobian"
    extends Icons.Example;
    Piezoloop.Controllers.JacobianCoordinator device(matrix = {0.05, 0.9, 1.1, -0.2}, offset = {0.5, -0.3}, entries = 4, axes = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave wave2(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave measured1(scale = 4e-08, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Wave measured2(scale = 2e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
    Types.Position command[2] "Twice the reference less the measured motion: feedback of gain 1";
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured1.y, device.measured[1]) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(measured2.y, device.measured[2]) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    command[1] = 2*device.y[1] - device.measured_motion[1];
    command[2] = 2*device.y[2] - device.measured_motion[2];
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Controllers.JacobianCoordinator as it is compared with the FMU.</p></html>"));
  end JacobianCoordinator;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Controllers;

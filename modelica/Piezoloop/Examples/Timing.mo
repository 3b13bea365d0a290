within Piezoloop.Examples;
package Timing "Examples of single blocks: Timing"
  extends Icons.ExamplesPackage;

  model Delay "Transport delay (computing, bus, converter), also by a fraction of a step"
    extends Icons.Example;
    Piezoloop.Blocks.Timing.Delay device(delay_ = 0.00033, longest = 0.001, cells = 12, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Timing.Delay as it is compared with the FMU.</p></html>"));
  end Delay;

  model ClockOffset "Offset and jitter of the sample clock, as a delay that changes"
    extends Icons.Example;
    Piezoloop.Blocks.Timing.ClockOffset device(initial_ = 0.00024, offset = 0.01, longest = 0.001, cells = 12, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Constant n(k = 0.0) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(n.y, device.n) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Timing.ClockOffset as it is compared with the FMU.</p></html>"));
  end ClockOffset;

  model DacQuantisation "Resolution of the command's converter"
    extends Icons.Example;
    Piezoloop.Blocks.Timing.DacQuantisation device(resolution = 0.37, phase = 0.3) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Timing.DacQuantisation as it is compared with the FMU.</p></html>"));
  end DacQuantisation;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Timing;

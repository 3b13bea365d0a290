within Piezoloop.Examples;
package Hysteresis "Examples of single blocks: Hysteresis"
  extends Icons.ExamplesPackage;

  model PrandtlIshlinskii "Symmetric hysteresis, independent of rate: a weighted sum of play operators"
    extends Icons.Example;
    Piezoloop.Hysteresis.PrandtlIshlinskii device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.PrandtlIshlinskii as it is compared with the FMU.</p></html>"));
  end PrandtlIshlinskii;

  model ModifiedPrandtlIshlinskii "Asymmetric hysteresis, independent of rate: plays followed by one-sided dead zones"
    extends Icons.Example;
    Piezoloop.Hysteresis.ModifiedPrandtlIshlinskii device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, edge = {-1.0, 1.5, 3.0}, slope = {0.1, -0.2, 0.3}, plays = 4, zones = 3, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.ModifiedPrandtlIshlinskii as it is compared with the FMU.</p></html>"));
  end ModifiedPrandtlIshlinskii;

  model SkewedPlay "Asymmetric hysteresis, independent of rate: plays that are wider at one end of the range"
    extends Icons.Example;
    Piezoloop.Hysteresis.SkewedPlay device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, skew = {0.0, 0.01, -0.005, 0.002}, play_weight = 0.01, width = 0.2, width_growth = 0.1, width_curvature = -0.05, centre = 50.0, half_range = 60.0, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.SkewedPlay as it is compared with the FMU.</p></html>"));
  end SkewedPlay;

  model GeneralisedPlay "Asymmetric, saturating hysteresis: plays between hyperbolic-tangent envelopes"
    extends Icons.Example;
    Piezoloop.Hysteresis.GeneralisedPlay device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, left_a0 = 90.0, left_a1 = 0.012, left_a2 = -0.1, left_a3 = 2.0, right_a0 = 95.0, right_a1 = 0.0125, right_a2 = 0.0, right_a3 = 6.0, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.GeneralisedPlay as it is compared with the FMU.</p></html>"));
  end GeneralisedPlay;

  model Preisach "Discrete Preisach hysteresis: weighted relays, in constant time per step"
    extends Icons.Example;
    Piezoloop.Hysteresis.Preisach device(mu = {0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02}, low = -5.0, high = 110.0, offset = 0.1, relays = 36, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.Preisach as it is compared with the FMU.</p></html>"));
  end Preisach;

  model BoucWen "Bouc-Wen hysteresis, symmetric or asymmetric, exact over each step"
    extends Icons.Example;
    Piezoloop.Hysteresis.BoucWen device(gain = 0.08, alpha = 0.3, beta = 0.04, gamma = 0.015, delta = 0.004, offset = 0.2, exponent = 1.6, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.BoucWen as it is compared with the FMU.</p></html>"));
  end BoucWen;

  model Duhem "Duhem hysteresis (Coleman-Hodgdon) with a straight centre line, exact over each step"
    extends Icons.Example;
    Piezoloop.Hysteresis.Duhem device(slope = 0.08, initial_ = 0.055, decay = 0.04, offset = 0.2, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.Duhem as it is compared with the FMU.</p></html>"));
  end Duhem;

  model Dahl "Dahl hysteresis: a spring that yields, exact over each step"
    extends Icons.Example;
    Piezoloop.Hysteresis.Dahl device(gain = 0.08, height = 0.6, length = 20.0, offset = 0.2, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.Dahl as it is compared with the FMU.</p></html>"));
  end Dahl;

  model RateDependentPlay "Hysteresis that widens with the rate: plays with rate-dependent thresholds"
    extends Icons.Example;
    Piezoloop.Hysteresis.RateDependentPlay device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, gain = 0.02, rate = 0.0002, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.RateDependentPlay as it is compared with the FMU.</p></html>"));
  end RateDependentPlay;

  model LaggingPlay "Hysteresis whose memory lags behind the command"
    extends Icons.Example;
    Piezoloop.Hysteresis.LaggingPlay device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, gain = 0.02, bandwidth = 80.0, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.LaggingPlay as it is compared with the FMU.</p></html>"));
  end LaggingPlay;

  model Grpi "Generalised rate-dependent Prandtl-Ishlinskii hysteresis"
    extends Icons.Example;
    Piezoloop.Hysteresis.Grpi device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, a1 = 1.02, a2 = -0.0001, b1 = 0.97, b2 = 0.0002, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.Grpi as it is compared with the FMU.</p></html>"));
  end Grpi;

  model Mpi "Modified rate-dependent Prandtl-Ishlinskii hysteresis: plays and a cubic polynomial"
    extends Icons.Example;
    Piezoloop.Hysteresis.Mpi device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, linear = 0.03, cubic = 1e-07, scale = 1.1, rate = 0.0001, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.Mpi as it is compared with the FMU.</p></html>"));
  end Mpi;

  model DynamicPrandtlIshlinskii "Prandtl-Ishlinskii hysteresis whose weights follow the command's rate in segments"
    extends Icons.Example;
    Piezoloop.Hysteresis.DynamicPrandtlIshlinskii device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, alpha = {1e-08, 2e-08, 3e-08, 1e-08}, beta = {2e-12, 1e-12, 1e-12, 3e-12}, plays = 4, segments = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Hysteresis.DynamicPrandtlIshlinskii as it is compared with the FMU.</p></html>"));
  end DynamicPrandtlIshlinskii;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Hysteresis;

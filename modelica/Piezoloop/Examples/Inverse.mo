within Piezoloop.Examples;
package Inverse "Examples of single blocks: Inverse"
  extends Icons.ExamplesPackage;

  model InversePrandtlIshlinskii "Exact inverse of a Prandtl-Ishlinskii model, given by the forward model's parameters"
    extends Icons.Example;
    Piezoloop.Inverse.InversePrandtlIshlinskii device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InversePrandtlIshlinskii as it is compared with the FMU.</p></html>"));
  end InversePrandtlIshlinskii;

  model InverseModifiedPrandtlIshlinskii "Exact inverse of a modified Prandtl-Ishlinskii model, given by its parameters"
    extends Icons.Example;
    Piezoloop.Inverse.InverseModifiedPrandtlIshlinskii device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, edge = {-1.0, 1.5, 3.0}, slope = {0.1, -0.2, 0.3}, plays = 4, zones = 3, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseModifiedPrandtlIshlinskii as it is compared with the FMU.</p></html>"));
  end InverseModifiedPrandtlIshlinskii;

  model InverseGeneralisedPlay "Exact right inverse of a generalised-play model, given by its parameters"
    extends Icons.Example;
    Piezoloop.Inverse.InverseGeneralisedPlay device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, left_a0 = 90.0, left_a1 = 0.012, left_a2 = -0.1, left_a3 = 2.0, right_a0 = 95.0, right_a1 = 0.0125, right_a2 = 0.0, right_a3 = 6.0, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseGeneralisedPlay as it is compared with the FMU.</p></html>"));
  end InverseGeneralisedPlay;

  model InversePreisach "Inverse of a discrete Preisach model, by bisection over its levels"
    extends Icons.Example;
    Piezoloop.Inverse.InversePreisach device(mu = {0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02, 0.06, 0.1, 0.04, 0.08, 0.02}, low = -5.0, high = 110.0, offset = 0.1, relays = 36, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InversePreisach as it is compared with the FMU.</p></html>"));
  end InversePreisach;

  model InverseBoucWen "Inverse of a Bouc-Wen model, solved at each step"
    extends Icons.Example;
    Piezoloop.Inverse.InverseBoucWen device(gain = 0.08, alpha = 0.3, beta = 0.04, gamma = 0.015, delta = 0.004, offset = 0.2, command_min = -20.0, command_max = 160.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseBoucWen as it is compared with the FMU.</p></html>"));
  end InverseBoucWen;

  model InverseDuhem "Inverse of a Duhem model, solved at each step"
    extends Icons.Example;
    Piezoloop.Inverse.InverseDuhem device(slope = 0.08, initial_ = 0.055, decay = 0.04, offset = 0.2, command_min = -20.0, command_max = 160.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseDuhem as it is compared with the FMU.</p></html>"));
  end InverseDuhem;

  model InverseDahl "Inverse of a Dahl model, solved at each step"
    extends Icons.Example;
    Piezoloop.Inverse.InverseDahl device(gain = 0.08, height = 0.6, length = 20.0, offset = 0.2, command_min = -20.0, command_max = 160.0, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseDahl as it is compared with the FMU.</p></html>"));
  end InverseDahl;

  model InverseRateDependentPlay "Inverse of a rate-dependent-play model, solved at each step"
    extends Icons.Example;
    Piezoloop.Inverse.InverseRateDependentPlay device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, command_min = -20.0, command_max = 160.0, gain = 0.02, rate = 0.0002, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseRateDependentPlay as it is compared with the FMU.</p></html>"));
  end InverseRateDependentPlay;

  model InverseGrpi "Inverse of a grpi model, solved at each step"
    extends Icons.Example;
    Piezoloop.Inverse.InverseGrpi device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, command_min = -20.0, command_max = 160.0, a1 = 1.02, a2 = -0.0001, b1 = 0.97, b2 = 0.0002, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseGrpi as it is compared with the FMU.</p></html>"));
  end InverseGrpi;

  model InverseMpi "Inverse of an mpi model, solved at each step"
    extends Icons.Example;
    Piezoloop.Inverse.InverseMpi device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, command_min = -20.0, command_max = 160.0, linear = 0.03, cubic = 1e-07, scale = 1.1, rate = 0.0001, plays = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseMpi as it is compared with the FMU.</p></html>"));
  end InverseMpi;

  model InverseDynamicPrandtlIshlinskii "Inverse of a dynamic Prandtl-Ishlinskii model, solved at each step"
    extends Icons.Example;
    Piezoloop.Inverse.InverseDynamicPrandtlIshlinskii device(r = {0.0, 8.0, 20.0, 35.0}, w = {0.02, 0.03, 0.01, 0.015}, offset = 0.3, command_min = -20.0, command_max = 160.0, alpha = {1e-08, 2e-08, 3e-08, 1e-08}, beta = {2e-12, 1e-12, 1e-12, 3e-12}, plays = 4, segments = 4, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseDynamicPrandtlIshlinskii as it is compared with the FMU.</p></html>"));
  end InverseDynamicPrandtlIshlinskii;

  model InverseKelvinVoigtCreep "Inverse of Kelvin-Voigt creep: removes it from the reference"
    extends Icons.Example;
    Piezoloop.Inverse.InverseKelvinVoigtCreep device(share = {0.05, 0.03}, time_constant = {0.003, 0.03}, elements = 2, step = 0.0001) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 8e-08, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Inverse.InverseKelvinVoigtCreep as it is compared with the FMU.</p></html>"));
  end InverseKelvinVoigtCreep;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Inverse;

within Piezoloop.Examples;
package Coupling "Examples of single blocks: Coupling"
  extends Icons.ExamplesPackage;

  model CommandCoupling "Static coupling from the neighbours' commands"
    extends Icons.Example;
    Piezoloop.Blocks.Coupling.CommandCoupling device(matrix = {0.0, 0.01, 0.02, 0.0}, entries = 4, axes = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave wave2(scale = 1e-07, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave command1(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Wave command2(scale = 1.0, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(command1.y, device.command[1]) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(command2.y, device.command[2]) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Coupling.CommandCoupling as it is compared with the FMU.</p></html>"));
  end CommandCoupling;

  model DisplacementCoupling "Coupling from the neighbours' motion, with their dynamics"
    extends Icons.Example;
    Piezoloop.Blocks.Coupling.DisplacementCoupling device(matrix = {0.0, 0.1, -0.2, 0.0}, entries = 4, axes = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave wave2(scale = 1e-07, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Coupling.DisplacementCoupling as it is compared with the FMU.</p></html>"));
  end DisplacementCoupling;

  model ModeCoupling "Coupling from the neighbours' commands through a mode of each neighbour"
    extends Icons.Example;
    Piezoloop.Blocks.Coupling.ModeCoupling device(matrix = {0.0, 0.01, 0.02, 0.0}, frequency = {300.0, 250.0}, damping = {0.05, 0.1}, entries = 4, axes = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave wave2(scale = 1e-07, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave command1(scale = 1.0, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Wave command2(scale = 1.0, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    connect(command1.y, device.command[1]) annotation(Line(points={{-59,0},{-40,0},{-40,0},{-24,0}}, color={0,0,127}));
    connect(command2.y, device.command[2]) annotation(Line(points={{-59,-30},{-40,-30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Coupling.ModeCoupling as it is compared with the FMU.</p></html>"));
  end ModeCoupling;

  model ModalMatrix "Linear structure with several inputs and outputs: modes that all axes share"
    extends Icons.Example;
    Piezoloop.Blocks.Coupling.ModalMatrix device(direct = {0.2, 0.0, 0.1, 0.3}, frequency = {300.0, 150.0}, damping = {0.05, 1.2}, residue = {0.5, 0.1, -0.2, 0.6, 0.3, 0.0, 0.1, 0.2}, rate_residue = {0.02, 0.0, 0.0, -0.01, 0.0, 0.03, 0.0, 0.0}, modes = 2, residues = 8, entries = 4, axes = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave wave2(scale = 1e-07, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Coupling.ModalMatrix as it is compared with the FMU.</p></html>"));
  end ModalMatrix;

  model SofteningModes "Modes that all axes share, with frequency and damping that follow the amplitude"
    extends Icons.Example;
    Piezoloop.Blocks.Coupling.SofteningModes device(direct = {0.2, 0.0, 0.1, 0.3}, frequency = {300.0, 150.0}, damping = {0.05, 1.2}, frequency_shift = {-0.1, -0.05}, damping_growth = {0.5, 0.2}, residue = {0.5, 0.1, -0.2, 0.6, 0.3, 0.0, 0.1, 0.2}, rate_residue = {0.02, 0.0, 0.0, -0.01, 0.0, 0.03, 0.0, 0.0}, amplitude = {3.0, 3.0}, exponent = 2.0, modes = 2, residues = 8, entries = 4, axes = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave wave2(scale = 1e-07, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Coupling.SofteningModes as it is compared with the FMU.</p></html>"));
  end SofteningModes;

  model OpticsJacobian "From the angles of several mirrors to the coordinates of the spots on the sensors"
    extends Icons.Example;
    Piezoloop.Blocks.Coupling.OpticsJacobian device(matrix = {1.0, 0.1, -0.2, 0.9}, offset = {0.5, -0.5}, entries = 4, axes = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave wave2(scale = 1e-07, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Coupling.OpticsJacobian as it is compared with the FMU.</p></html>"));
  end OpticsJacobian;

  model PsdPincushion "Pincushion distortion of a position-sensitive detector"
    extends Icons.Example;
    Piezoloop.Blocks.Coupling.PsdPincushion device(distortion = 0.03, half_size = 12.0, axes = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
    Sources.Wave wave2(scale = 1e-07, amplitude = {30.0}, frequency = {90.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,30},{-40,30},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Coupling.PsdPincushion as it is compared with the FMU.</p></html>"));
  end PsdPincushion;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Coupling;

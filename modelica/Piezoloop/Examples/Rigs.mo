within Piezoloop.Examples;
package Rigs "Each rig under waves"
  extends Icons.ExamplesPackage;

  model P0 "Laser beam steering, four axes, as a controller may know it"
    extends Icons.Example;
    Piezoloop.Rigs.P0 device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {22.5, 7.5}, frequency = {16.6667, 45.977}, step = 0.00025) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave wave2(amplitude = {22.5, 7.5}, frequency = {8.33333, 22.9885}, step = 0.00025) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Wave wave3(amplitude = {22.5, 7.5}, frequency = {5.55556, 15.3257}, step = 0.00025) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
    Sources.Wave wave4(amplitude = {22.5, 7.5}, frequency = {4.16667, 11.4943}, step = 0.00025) annotation(Placement(transformation(extent={{-80,-70},{-60,-50}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,0},{-24,0}}, color={0,0,127}));
    connect(wave3.y, device.u[3]) annotation(Line(points={{-59,-30},{-24,0}}, color={0,0,127}));
    connect(wave4.y, device.u[4]) annotation(Line(points={{-59,-60},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.07475, Interval=0.00025, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P0 as it is compared with its FMU.</p></html>"));
  end P0;

  model P0Truth "Laser beam steering as a machine: asymmetric hysteresis, creep, modes, detectors"
    extends Icons.Example;
    Piezoloop.Rigs.P0Truth device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {22.5, 7.5}, frequency = {16.6667, 45.977}, step = 0.00025) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave wave2(amplitude = {22.5, 7.5}, frequency = {8.33333, 22.9885}, step = 0.00025) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Wave wave3(amplitude = {22.5, 7.5}, frequency = {5.55556, 15.3257}, step = 0.00025) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
    Sources.Wave wave4(amplitude = {22.5, 7.5}, frequency = {4.16667, 11.4943}, step = 0.00025) annotation(Placement(transformation(extent={{-80,-70},{-60,-50}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,0},{-24,0}}, color={0,0,127}));
    connect(wave3.y, device.u[3]) annotation(Line(points={{-59,-30},{-24,0}}, color={0,0,127}));
    connect(wave4.y, device.u[4]) annotation(Line(points={{-59,-60},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.07475, Interval=0.00025, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P0Truth as it is compared with its FMU.</p></html>"));
  end P0Truth;

  model P0Machine "Laser beam steering as it could be: Rayleigh hysteresis, creep, modes, detectors with noise"
    extends Icons.Example;
    Piezoloop.Rigs.P0Machine device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {22.5, 7.5}, frequency = {16.6667, 45.977}, step = 0.00025) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave wave2(amplitude = {22.5, 7.5}, frequency = {8.33333, 22.9885}, step = 0.00025) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
    Sources.Wave wave3(amplitude = {22.5, 7.5}, frequency = {5.55556, 15.3257}, step = 0.00025) annotation(Placement(transformation(extent={{-80,-40},{-60,-20}})));
    Sources.Wave wave4(amplitude = {22.5, 7.5}, frequency = {4.16667, 11.4943}, step = 0.00025) annotation(Placement(transformation(extent={{-80,-70},{-60,-50}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,0},{-24,0}}, color={0,0,127}));
    connect(wave3.y, device.u[3]) annotation(Line(points={{-59,-30},{-24,0}}, color={0,0,127}));
    connect(wave4.y, device.u[4]) annotation(Line(points={{-59,-60},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.07475, Interval=0.00025, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P0Machine as it is compared with its FMU.</p></html>"));
  end P0Machine;

  model P1 "P-752.21C nanopositioning stage, linear"
    extends Icons.Example;
    Piezoloop.Rigs.P1 device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {1.8, 0.6}, frequency = {20.8333, 57.4713}, step = 0.0002) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0598, Interval=0.0002, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P1 as it is compared with its FMU.</p></html>"));
  end P1;

  model P1Truth "P-752.21C stage as a machine: Kuhnen hysteresis, creep, sensor"
    extends Icons.Example;
    Piezoloop.Rigs.P1Truth device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {1.8, 0.6}, frequency = {20.8333, 57.4713}, step = 0.0002) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0598, Interval=0.0002, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P1Truth as it is compared with its FMU.</p></html>"));
  end P1Truth;

  model P1Machine "P-752.21C stage as it could be: Rayleigh hysteresis of a measured PICMA stack, creep, 40 Hz low-pass"
    extends Icons.Example;
    Piezoloop.Rigs.P1Machine device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {1.8, 0.6}, frequency = {20.8333, 57.4713}, step = 0.0002) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0598, Interval=0.0002, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P1Machine as it is compared with its FMU.</p></html>"));
  end P1Machine;

  model P2 "Piezo bimorph, Bouc-Wen hysteresis in front of a lightly damped mode, as printed"
    extends Icons.Example;
    Piezoloop.Rigs.P2 device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {1.8, 0.6}, frequency = {41.6667, 114.943}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P2 as it is compared with its FMU.</p></html>"));
  end P2;

  model P2Truth "Piezo bimorph as a machine: plays that widen with the rate, creep, a light mode, laser sensor"
    extends Icons.Example;
    Piezoloop.Rigs.P2Truth device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {1.8, 0.6}, frequency = {41.6667, 114.943}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P2Truth as it is compared with its FMU.</p></html>"));
  end P2Truth;

  model P2Machine "Piezo bimorph as it could be: Rayleigh hysteresis, creep, a light mode, laser sensor"
    extends Icons.Example;
    Piezoloop.Rigs.P2Machine device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {1.8, 0.6}, frequency = {41.6667, 114.943}, step = 0.0001) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P2Machine as it is compared with its FMU.</p></html>"));
  end P2Machine;

  model P3 "P66X30 nanopositioning stage, linear"
    extends Icons.Example;
    Piezoloop.Rigs.P3 device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {1.5, 0.5}, frequency = {83.3333, 229.885}, step = 5e-05) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.01495, Interval=5e-05, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P3 as it is compared with its FMU.</p></html>"));
  end P3;

  model P3Truth "P66X30 stage as a machine: hysteresis that widens with the rate, creep, strain gauge"
    extends Icons.Example;
    Piezoloop.Rigs.P3Truth device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {1.8, 0.6}, frequency = {166.667, 459.77}, step = 2.5e-05) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.007475, Interval=2.5e-05, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P3Truth as it is compared with its FMU.</p></html>"));
  end P3Truth;

  model P3Machine "P66X30 stage as it could be: Rayleigh hysteresis, material loss, strain gauge"
    extends Icons.Example;
    Piezoloop.Rigs.P3Machine device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {1.8, 0.6}, frequency = {166.667, 459.77}, step = 2.5e-05) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.007475, Interval=2.5e-05, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P3Machine as it is compared with its FMU.</p></html>"));
  end P3Machine;

  model Evc "Elliptical vibration cutting device with two parallel-flexure axes"
    extends Icons.Example;
    Piezoloop.Rigs.Evc device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {18.0, 6.0}, frequency = {208.333, 574.713}, step = 2e-05) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave wave2(amplitude = {18.0, 6.0}, frequency = {104.167, 287.356}, step = 2e-05) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.00598, Interval=2e-05, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.Evc as it is compared with its FMU.</p></html>"));
  end Evc;

  model P4Truth "Elliptical vibration cutting device as a machine: asymmetric saturating hysteresis, creep, weak modes, sensor noise"
    extends Icons.Example;
    Piezoloop.Rigs.P4Truth device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {18.0, 6.0}, frequency = {208.333, 574.713}, step = 2e-05) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave wave2(amplitude = {18.0, 6.0}, frequency = {104.167, 287.356}, step = 2e-05) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.00598, Interval=2e-05, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P4Truth as it is compared with its FMU.</p></html>"));
  end P4Truth;

  model EvcTruth "Elliptical vibration cutting device as a machine: asymmetric hysteresis, creep, sensor noise"
    extends Icons.Example;
    Piezoloop.Rigs.EvcTruth device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {18.0, 6.0}, frequency = {208.333, 574.713}, step = 2e-05) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave wave2(amplitude = {18.0, 6.0}, frequency = {104.167, 287.356}, step = 2e-05) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.00598, Interval=2e-05, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.EvcTruth as it is compared with its FMU.</p></html>"));
  end EvcTruth;

  model P4Machine "Elliptical vibration cutting device as it could be: Rayleigh hysteresis, creep, the finite elements' modes"
    extends Icons.Example;
    Piezoloop.Rigs.P4Machine device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {18.0, 6.0}, frequency = {208.333, 574.713}, step = 2e-05) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
    Sources.Wave wave2(amplitude = {18.0, 6.0}, frequency = {104.167, 287.356}, step = 2e-05) annotation(Placement(transformation(extent={{-80,-10},{-60,10}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    connect(wave2.y, device.u[2]) annotation(Line(points={{-59,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.00598, Interval=2e-05, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P4Machine as it is compared with its FMU.</p></html>"));
  end P4Machine;

  model P885 "PI P-885.91 stack in an amplified flexure: delay, curved Prandtl-Ishlinskii hysteresis, creep"
    extends Icons.Example;
    Piezoloop.Rigs.P885 device annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave1(amplitude = {0.54, 0.18}, frequency = {0.833333, 2.29885}, step = 0.005) annotation(Placement(transformation(extent={{-80,20},{-60,40}})));
  equation
    connect(wave1.y, device.u[1]) annotation(Line(points={{-59,30},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=1.495, Interval=0.005, Tolerance=1e-9),
      Documentation(info="<html><p>Rig Piezoloop.Rigs.P885 as it is compared with its FMU.</p></html>"));
  end P885;
  annotation(Documentation(info="<html><p>One model per rig.</p></html>"));
end Rigs;

within Piezoloop.Examples;
package Creep "Examples of single blocks: Creep"
  extends Icons.ExamplesPackage;

  model KelvinVoigtCreep "Creep as a sum of first-order elements with given time constants"
    extends Icons.Example;
    Piezoloop.Blocks.Creep.KelvinVoigtCreep device(share = {0.05, 0.03}, time_constant = {0.003, 0.03}, elements = 2) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Creep.KelvinVoigtCreep as it is compared with the FMU.</p></html>"));
  end KelvinVoigtCreep;

  model LogarithmicCreep "Creep in proportion to the logarithm of time"
    extends Icons.Example;
    Piezoloop.Blocks.Creep.LogarithmicCreep device(gain = 0.02) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Creep.LogarithmicCreep as it is compared with the FMU.</p></html>"));
  end LogarithmicCreep;

  model FractionalCreep "Creep as a power law of frequency between two frequencies"
    extends Icons.Example;
    Piezoloop.Blocks.Creep.FractionalCreep device(order = 0.1) annotation(Placement(transformation(extent={{-20,-20},{20,20}})));
    Sources.Wave wave(scale = 1e-07, amplitude = {40.0, 12.0}, frequency = {60.0, 170.0}, step = 0.0001) annotation(Placement(transformation(extent={{-80,50},{-60,70}})));
  equation
    connect(wave.y, device.u) annotation(Line(points={{-59,60},{-40,60},{-40,0},{-24,0}}, color={0,0,127}));
    annotation(experiment(StartTime=0, StopTime=0.0299, Interval=0.0001, Tolerance=1e-9),
      Documentation(info="<html><p>Block Piezoloop.Blocks.Creep.FractionalCreep as it is compared with the FMU.</p></html>"));
  end FractionalCreep;
  annotation(Documentation(info="<html><p>One model per block; the numbers are those of the comparison with the FMU.</p></html>"));
end Creep;

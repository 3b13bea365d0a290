within Piezoloop;
package Rigs "Known machines, as the tool's blueprints have them"
  extends Icons.Package;

  block Hold "Hands a position on once per step"
    extends Icons.Block;
    Interfaces.PositionInput u "Position in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y "Position at the last sample" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real u_start(unit="m") = 0 "Position before the first sample";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real held(start = u_start, fixed = true, unit="m") "Position at the last sample";
  equation
    when sample((1 - 1e-7)*step, step) then
      held = u;
    end when;
    y = held;
    annotation(Icon(graphics={Line(points={{-80,-60},{-40,-60},{-40,-20},{0,-20},{0,20},{40,20},{40,60},{80,60}}, color={0,0,127})}),
      Documentation(info="<html><p>Sampled just before the end of each step, so that a block with direct feed-through is read with the input that it had.</p></html>"));
  end Hold;

  block HoldCommand "Hands a command on once per step"
    extends Icons.Block;
    Interfaces.CommandInput u "Command in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.CommandOutput y "Command at the last sample" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real u_start(unit="V") = 0 "Command before the first sample";
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real held(start = u_start, fixed = true, unit="V") "Command at the last sample";
  equation
    when sample((1 - 1e-7)*step, step) then
      held = u;
    end when;
    y = held;
    annotation(Icon(graphics={Line(points={{-80,-60},{-40,-60},{-40,-20},{0,-20},{0,20},{40,20},{40,60},{80,60}}, color={0,0,127})}),
      Documentation(info="<html><p>Sampled just before the end of each step.</p></html>"));
  end HoldCommand;

  block P0 "Laser beam steering, four axes, as a controller may know it"
    extends Icons.Rig;
    Interfaces.CommandInput u[4] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[4] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 0.00025 "Time between samples: the step of the blueprint";
    Piezoloop.Electrical.AmplifierLag driver1(bandwidth = 500.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Hysteresis.PrandtlIshlinskii hysteresis1(r = {0.0, 15.0, 30.0, 45.0, 60.0}, w = {0.004, 0.0008, 0.0008, 0.0008, 0.0008}, offset = 0.0, plays = 5, step = step) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Piezoloop.Electrical.AmplifierLag driver2(bandwidth = 500.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,-28},{-72,-12}})));
    Piezoloop.Hysteresis.PrandtlIshlinskii hysteresis2(r = {0.0, 15.0, 30.0, 45.0, 60.0}, w = {0.004, 0.0008, 0.0008, 0.0008, 0.0008}, offset = 0.0, plays = 5, step = step) annotation(Placement(transformation(extent={{-58,-28},{-42,-12}})));
    Piezoloop.Electrical.AmplifierLag driver3(bandwidth = 500.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,-88},{-72,-72}})));
    Piezoloop.Hysteresis.PrandtlIshlinskii hysteresis3(r = {0.0, 15.0, 30.0, 45.0, 60.0}, w = {0.004, 0.0008, 0.0008, 0.0008, 0.0008}, offset = 0.0, plays = 5, step = step) annotation(Placement(transformation(extent={{-58,-88},{-42,-72}})));
    Piezoloop.Electrical.AmplifierLag driver4(bandwidth = 500.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,-148},{-72,-132}})));
    Piezoloop.Hysteresis.PrandtlIshlinskii hysteresis4(r = {0.0, 15.0, 30.0, 45.0, 60.0}, w = {0.004, 0.0008, 0.0008, 0.0008, 0.0008}, offset = 0.0, plays = 5, step = step) annotation(Placement(transformation(extent={{-58,-148},{-42,-132}})));
    Piezoloop.Blocks.Coupling.OpticsJacobian optics(matrix = {504.693, 3.33402, 0.0, 0.0, 14.4123, -515.344, 0.0, 0.0, 210.358, -12.0015, -129.337, 7.85753, 1.1847, 217.263, -3.04729, -142.002}, offset = {-261.625, 272.281, -46.6467, -39.121}, entries = 16, axes = 4) annotation(Placement(transformation(extent={{-30,-10},{-10,10}})));
    Piezoloop.Sensors.SensorButterworth filter1(bandwidth = 50.0, order = 2) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Piezoloop.Sensors.SensorButterworth filter2(bandwidth = 50.0, order = 2) annotation(Placement(transformation(extent={{2,-28},{18,-12}})));
    Piezoloop.Sensors.SensorButterworth filter3(bandwidth = 50.0, order = 2) annotation(Placement(transformation(extent={{2,-88},{18,-72}})));
    Piezoloop.Sensors.SensorButterworth filter4(bandwidth = 50.0, order = 2) annotation(Placement(transformation(extent={{2,-148},{18,-132}})));
  equation
    connect(u[1], driver1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(driver1.y, hysteresis1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(u[2], driver2.u) annotation(Line(points={{-104,-20},{-90,-20}}, color={0,0,127}));
    connect(driver2.y, hysteresis2.u) annotation(Line(points={{-74,-20},{-60,-20}}, color={0,0,127}));
    connect(u[3], driver3.u) annotation(Line(points={{-104,-80},{-90,-80}}, color={0,0,127}));
    connect(driver3.y, hysteresis3.u) annotation(Line(points={{-74,-80},{-60,-80}}, color={0,0,127}));
    connect(u[4], driver4.u) annotation(Line(points={{-104,-140},{-90,-140}}, color={0,0,127}));
    connect(driver4.y, hysteresis4.u) annotation(Line(points={{-74,-140},{-60,-140}}, color={0,0,127}));
    connect(hysteresis1.y, optics.u[1]) annotation(Line(points={{-40,40},{-32,0}}, color={0,0,127}));
    connect(hysteresis2.y, optics.u[2]) annotation(Line(points={{-40,-20},{-32,0}}, color={0,0,127}));
    connect(hysteresis3.y, optics.u[3]) annotation(Line(points={{-40,-80},{-32,0}}, color={0,0,127}));
    connect(hysteresis4.y, optics.u[4]) annotation(Line(points={{-40,-140},{-32,0}}, color={0,0,127}));
    connect(optics.y[1], filter1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(optics.y[2], filter2.u) annotation(Line(points={{-14,-20},{0,-20}}, color={0,0,127}));
    connect(optics.y[3], filter3.u) annotation(Line(points={{-14,-80},{0,-80}}, color={0,0,127}));
    connect(optics.y[4], filter4.u) annotation(Line(points={{-14,-140},{0,-140}}, color={0,0,127}));
    connect(filter1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    connect(filter2.y, y[2]) annotation(Line(points={{100,-20},{110,-20}}, color={0,0,127}));
    connect(filter3.y, y[3]) annotation(Line(points={{100,-80},{110,-80}}, color={0,0,127}));
    connect(filter4.y, y[4]) annotation(Line(points={{100,-140},{110,-140}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p0</code>. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [1, 1, 1, 1] steps later.</p><p>Source: Laser beam pointing with four piezo axes and LS-SVM models; sections IV and V.</p></html>"));
  end P0;

  block P0Truth "Laser beam steering as a machine: asymmetric hysteresis, creep, modes, detectors"
    extends Icons.Rig;
    Interfaces.CommandInput u[4] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[4] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 0.00025 "Time between samples: the step of the blueprint";
    Piezoloop.Blocks.Timing.Delay delay1(delay_ = 0.0005, longest = 0.01, cells = 42, step = step) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Blocks.Timing.DacQuantisation dac1(resolution = 0.00229) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Piezoloop.Electrical.AmplifierLag driver1(bandwidth = 500.0, gain = 1.0) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
    Piezoloop.Hysteresis.ModifiedPrandtlIshlinskii hysteresis1(r = {0.0, 15.0, 30.0, 45.0, 60.0, 75.0}, w = {0.003317, 0.000284, 0.000284, 0.000284, 0.000284, 0.000284}, edge = {0.25, 0.5, 0.75}, slope = {0.65, 0.65, 0.65}, offset = 0.0, plays = 6, zones = 3, step = step) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep1(share = {0.004, 0.005, 0.006}, time_constant = {0.05, 0.5, 5.0}, elements = 3) annotation(Placement(transformation(extent={{32,32},{48,48}})));
    Hold mirror1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{52,34},{64,46}})));
    Piezoloop.Mechanics.Mode mirror1(frequency = 620.0, damping = 0.03, gain = 1.0) annotation(Placement(transformation(extent={{62,32},{78,48}})));
    Piezoloop.Blocks.Timing.Delay delay2(delay_ = 0.0005, longest = 0.01, cells = 42, step = step) annotation(Placement(transformation(extent={{-88,-28},{-72,-12}})));
    Piezoloop.Blocks.Timing.DacQuantisation dac2(resolution = 0.00229) annotation(Placement(transformation(extent={{-58,-28},{-42,-12}})));
    Piezoloop.Electrical.AmplifierLag driver2(bandwidth = 485.0, gain = 1.0) annotation(Placement(transformation(extent={{-28,-28},{-12,-12}})));
    Piezoloop.Hysteresis.ModifiedPrandtlIshlinskii hysteresis2(r = {0.0, 15.0, 30.0, 45.0, 60.0, 75.0}, w = {0.003317, 0.000284, 0.000284, 0.000284, 0.000284, 0.000284}, edge = {0.25, 0.5, 0.75}, slope = {0.65, 0.65, 0.65}, offset = 0.0, plays = 6, zones = 3, step = step) annotation(Placement(transformation(extent={{2,-28},{18,-12}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep2(share = {0.004, 0.00485, 0.006}, time_constant = {0.05, 0.5, 5.0}, elements = 3) annotation(Placement(transformation(extent={{32,-28},{48,-12}})));
    Hold mirror2_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{52,-26},{64,-14}})));
    Piezoloop.Mechanics.Mode mirror2(frequency = 601.4, damping = 0.03, gain = 1.0) annotation(Placement(transformation(extent={{62,-28},{78,-12}})));
    Piezoloop.Blocks.Timing.Delay delay3(delay_ = 0.0005, longest = 0.01, cells = 42, step = step) annotation(Placement(transformation(extent={{-88,-88},{-72,-72}})));
    Piezoloop.Blocks.Timing.DacQuantisation dac3(resolution = 0.00229) annotation(Placement(transformation(extent={{-58,-88},{-42,-72}})));
    Piezoloop.Electrical.AmplifierLag driver3(bandwidth = 515.0, gain = 1.0) annotation(Placement(transformation(extent={{-28,-88},{-12,-72}})));
    Piezoloop.Hysteresis.ModifiedPrandtlIshlinskii hysteresis3(r = {0.0, 15.0, 30.0, 45.0, 60.0, 75.0}, w = {0.003317, 0.000284, 0.000284, 0.000284, 0.000284, 0.000284}, edge = {0.25, 0.5, 0.75}, slope = {0.65, 0.65, 0.65}, offset = 0.0, plays = 6, zones = 3, step = step) annotation(Placement(transformation(extent={{2,-88},{18,-72}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep3(share = {0.004, 0.00515, 0.006}, time_constant = {0.05, 0.5, 5.0}, elements = 3) annotation(Placement(transformation(extent={{32,-88},{48,-72}})));
    Hold mirror3_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{52,-86},{64,-74}})));
    Piezoloop.Mechanics.Mode mirror3(frequency = 638.6, damping = 0.03, gain = 1.0) annotation(Placement(transformation(extent={{62,-88},{78,-72}})));
    Piezoloop.Blocks.Timing.Delay delay4(delay_ = 0.0005, longest = 0.01, cells = 42, step = step) annotation(Placement(transformation(extent={{-88,-148},{-72,-132}})));
    Piezoloop.Blocks.Timing.DacQuantisation dac4(resolution = 0.00229) annotation(Placement(transformation(extent={{-58,-148},{-42,-132}})));
    Piezoloop.Electrical.AmplifierLag driver4(bandwidth = 492.5, gain = 1.0) annotation(Placement(transformation(extent={{-28,-148},{-12,-132}})));
    Piezoloop.Hysteresis.ModifiedPrandtlIshlinskii hysteresis4(r = {0.0, 15.0, 30.0, 45.0, 60.0, 75.0}, w = {0.003317, 0.000284, 0.000284, 0.000284, 0.000284, 0.000284}, edge = {0.25, 0.5, 0.75}, slope = {0.65, 0.65, 0.65}, offset = 0.0, plays = 6, zones = 3, step = step) annotation(Placement(transformation(extent={{2,-148},{18,-132}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep4(share = {0.004, 0.004925, 0.006}, time_constant = {0.05, 0.5, 5.0}, elements = 3) annotation(Placement(transformation(extent={{32,-148},{48,-132}})));
    Hold mirror4_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{52,-146},{64,-134}})));
    Piezoloop.Mechanics.Mode mirror4(frequency = 610.7, damping = 0.03, gain = 1.0) annotation(Placement(transformation(extent={{62,-148},{78,-132}})));
    Piezoloop.Blocks.Coupling.DisplacementCoupling gimbal(matrix = {0.0, 0.004, 0.0, 0.0, 0.006, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.005, 0.0, 0.0, 0.003, 0.0}, entries = 16, axes = 4) annotation(Placement(transformation(extent={{90,-10},{110,10}})));
    Piezoloop.Blocks.Coupling.OpticsJacobian optics(matrix = {504.693, 3.33402, 0.0, 0.0, 14.4123, -515.344, 0.0, 0.0, 210.358, -12.0015, -129.337, 7.85753, 1.1847, 217.263, -3.04729, -142.002}, offset = {-261.625, 272.281, -46.6467, -39.121}, entries = 16, axes = 4) annotation(Placement(transformation(extent={{120,-10},{140,10}})));
    Piezoloop.Blocks.Coupling.PsdPincushion psd1(distortion = 0.01, half_size = 5000.0, axes = 2) annotation(Placement(transformation(extent={{150,-10},{170,10}})));
    Piezoloop.Blocks.Coupling.PsdPincushion psd2(distortion = 0.01, half_size = 5000.0, axes = 2) annotation(Placement(transformation(extent={{180,-10},{200,10}})));
    Piezoloop.Blocks.Environment.ThermalDrift drift1(rate = 0.002, settling = 0.0, time_constant = 1000.0, expansion = 0.0, temperature_change = 0.0) annotation(Placement(transformation(extent={{212,32},{228,48}})));
    Hold filter1_hold(u_start = -0.00026163992147667224, step = step) annotation(Placement(transformation(extent={{232,34},{244,46}})));
    Piezoloop.Sensors.SensorButterworth filter1(bandwidth = 50.0, order = 2) annotation(Placement(transformation(extent={{242,32},{258,48}})));
    Piezoloop.Sensors.SensorQuantisation adc1(resolution = 0.153) annotation(Placement(transformation(extent={{272,32},{288,48}})));
    Piezoloop.Blocks.Environment.ThermalDrift drift2(rate = -0.0015, settling = 0.0, time_constant = 1000.0, expansion = 0.0, temperature_change = 0.0) annotation(Placement(transformation(extent={{212,-28},{228,-12}})));
    Hold filter2_hold(u_start = 0.00027229652922920137, step = step) annotation(Placement(transformation(extent={{232,-26},{244,-14}})));
    Piezoloop.Sensors.SensorButterworth filter2(bandwidth = 50.0, order = 2) annotation(Placement(transformation(extent={{242,-28},{258,-12}})));
    Piezoloop.Sensors.SensorQuantisation adc2(resolution = 0.153) annotation(Placement(transformation(extent={{272,-28},{288,-12}})));
    Piezoloop.Blocks.Environment.ThermalDrift drift3(rate = 0.001, settling = 0.0, time_constant = 1000.0, expansion = 0.0, temperature_change = 0.0) annotation(Placement(transformation(extent={{212,-88},{228,-72}})));
    Hold filter3_hold(u_start = -4.6646769155920704e-05, step = step) annotation(Placement(transformation(extent={{232,-86},{244,-74}})));
    Piezoloop.Sensors.SensorButterworth filter3(bandwidth = 50.0, order = 2) annotation(Placement(transformation(extent={{242,-88},{258,-72}})));
    Piezoloop.Sensors.SensorQuantisation adc3(resolution = 0.153) annotation(Placement(transformation(extent={{272,-88},{288,-72}})));
    Piezoloop.Blocks.Environment.ThermalDrift drift4(rate = -0.002, settling = 0.0, time_constant = 1000.0, expansion = 0.0, temperature_change = 0.0) annotation(Placement(transformation(extent={{212,-148},{228,-132}})));
    Hold filter4_hold(u_start = -3.912105799871747e-05, step = step) annotation(Placement(transformation(extent={{232,-146},{244,-134}})));
    Piezoloop.Sensors.SensorButterworth filter4(bandwidth = 50.0, order = 2) annotation(Placement(transformation(extent={{242,-148},{258,-132}})));
    Piezoloop.Sensors.SensorQuantisation adc4(resolution = 0.153) annotation(Placement(transformation(extent={{272,-148},{288,-132}})));
  equation
    connect(u[1], delay1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(delay1.y, dac1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(dac1.y, driver1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(driver1.y, hysteresis1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(hysteresis1.y, creep1.u) annotation(Line(points={{16,40},{30,40}}, color={0,0,127}));
    connect(creep1.y, mirror1_hold.u) annotation(Line(points={{46,40},{52,40}}, color={0,0,127}));
    connect(mirror1_hold.y, mirror1.u) annotation(Line(points={{46,40},{60,40}}, color={0,0,127}));
    connect(u[2], delay2.u) annotation(Line(points={{-104,-20},{-90,-20}}, color={0,0,127}));
    connect(delay2.y, dac2.u) annotation(Line(points={{-74,-20},{-60,-20}}, color={0,0,127}));
    connect(dac2.y, driver2.u) annotation(Line(points={{-44,-20},{-30,-20}}, color={0,0,127}));
    connect(driver2.y, hysteresis2.u) annotation(Line(points={{-14,-20},{0,-20}}, color={0,0,127}));
    connect(hysteresis2.y, creep2.u) annotation(Line(points={{16,-20},{30,-20}}, color={0,0,127}));
    connect(creep2.y, mirror2_hold.u) annotation(Line(points={{46,-20},{52,-20}}, color={0,0,127}));
    connect(mirror2_hold.y, mirror2.u) annotation(Line(points={{46,-20},{60,-20}}, color={0,0,127}));
    connect(u[3], delay3.u) annotation(Line(points={{-104,-80},{-90,-80}}, color={0,0,127}));
    connect(delay3.y, dac3.u) annotation(Line(points={{-74,-80},{-60,-80}}, color={0,0,127}));
    connect(dac3.y, driver3.u) annotation(Line(points={{-44,-80},{-30,-80}}, color={0,0,127}));
    connect(driver3.y, hysteresis3.u) annotation(Line(points={{-14,-80},{0,-80}}, color={0,0,127}));
    connect(hysteresis3.y, creep3.u) annotation(Line(points={{16,-80},{30,-80}}, color={0,0,127}));
    connect(creep3.y, mirror3_hold.u) annotation(Line(points={{46,-80},{52,-80}}, color={0,0,127}));
    connect(mirror3_hold.y, mirror3.u) annotation(Line(points={{46,-80},{60,-80}}, color={0,0,127}));
    connect(u[4], delay4.u) annotation(Line(points={{-104,-140},{-90,-140}}, color={0,0,127}));
    connect(delay4.y, dac4.u) annotation(Line(points={{-74,-140},{-60,-140}}, color={0,0,127}));
    connect(dac4.y, driver4.u) annotation(Line(points={{-44,-140},{-30,-140}}, color={0,0,127}));
    connect(driver4.y, hysteresis4.u) annotation(Line(points={{-14,-140},{0,-140}}, color={0,0,127}));
    connect(hysteresis4.y, creep4.u) annotation(Line(points={{16,-140},{30,-140}}, color={0,0,127}));
    connect(creep4.y, mirror4_hold.u) annotation(Line(points={{46,-140},{52,-140}}, color={0,0,127}));
    connect(mirror4_hold.y, mirror4.u) annotation(Line(points={{46,-140},{60,-140}}, color={0,0,127}));
    connect(mirror1.y, gimbal.u[1]) annotation(Line(points={{80,40},{88,0}}, color={0,0,127}));
    connect(mirror2.y, gimbal.u[2]) annotation(Line(points={{80,-20},{88,0}}, color={0,0,127}));
    connect(mirror3.y, gimbal.u[3]) annotation(Line(points={{80,-80},{88,0}}, color={0,0,127}));
    connect(mirror4.y, gimbal.u[4]) annotation(Line(points={{80,-140},{88,0}}, color={0,0,127}));
    connect(gimbal.y[1], optics.u[1]) annotation(Line(points={{110,40},{118,0}}, color={0,0,127}));
    connect(gimbal.y[2], optics.u[2]) annotation(Line(points={{110,-20},{118,0}}, color={0,0,127}));
    connect(gimbal.y[3], optics.u[3]) annotation(Line(points={{110,-80},{118,0}}, color={0,0,127}));
    connect(gimbal.y[4], optics.u[4]) annotation(Line(points={{110,-140},{118,0}}, color={0,0,127}));
    connect(optics.y[1], psd1.u[1]) annotation(Line(points={{140,40},{148,0}}, color={0,0,127}));
    connect(optics.y[2], psd1.u[2]) annotation(Line(points={{140,-20},{148,0}}, color={0,0,127}));
    connect(optics.y[3], psd2.u[1]) annotation(Line(points={{170,-80},{178,0}}, color={0,0,127}));
    connect(optics.y[4], psd2.u[2]) annotation(Line(points={{170,-140},{178,0}}, color={0,0,127}));
    connect(psd1.y[1], drift1.u) annotation(Line(points={{196,40},{210,40}}, color={0,0,127}));
    connect(drift1.y, filter1_hold.u) annotation(Line(points={{226,40},{232,40}}, color={0,0,127}));
    connect(filter1_hold.y, filter1.u) annotation(Line(points={{226,40},{240,40}}, color={0,0,127}));
    connect(filter1.y, adc1.u) annotation(Line(points={{256,40},{270,40}}, color={0,0,127}));
    connect(psd1.y[2], drift2.u) annotation(Line(points={{196,-20},{210,-20}}, color={0,0,127}));
    connect(drift2.y, filter2_hold.u) annotation(Line(points={{226,-20},{232,-20}}, color={0,0,127}));
    connect(filter2_hold.y, filter2.u) annotation(Line(points={{226,-20},{240,-20}}, color={0,0,127}));
    connect(filter2.y, adc2.u) annotation(Line(points={{256,-20},{270,-20}}, color={0,0,127}));
    connect(psd2.y[1], drift3.u) annotation(Line(points={{196,-80},{210,-80}}, color={0,0,127}));
    connect(drift3.y, filter3_hold.u) annotation(Line(points={{226,-80},{232,-80}}, color={0,0,127}));
    connect(filter3_hold.y, filter3.u) annotation(Line(points={{226,-80},{240,-80}}, color={0,0,127}));
    connect(filter3.y, adc3.u) annotation(Line(points={{256,-80},{270,-80}}, color={0,0,127}));
    connect(psd2.y[2], drift4.u) annotation(Line(points={{196,-140},{210,-140}}, color={0,0,127}));
    connect(drift4.y, filter4_hold.u) annotation(Line(points={{226,-140},{232,-140}}, color={0,0,127}));
    connect(filter4_hold.y, filter4.u) annotation(Line(points={{226,-140},{240,-140}}, color={0,0,127}));
    connect(filter4.y, adc4.u) annotation(Line(points={{256,-140},{270,-140}}, color={0,0,127}));
    connect(adc1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    connect(adc2.y, y[2]) annotation(Line(points={{100,-20},{110,-20}}, color={0,0,127}));
    connect(adc3.y, y[3]) annotation(Line(points={{100,-80},{110,-80}}, color={0,0,127}));
    connect(adc4.y, y[4]) annotation(Line(points={{100,-140},{110,-140}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p0-truth</code>. Without disturbances: M1x.floor, M1x.noise, M1x.hum, M1y.floor, M1y.noise, M1y.hum, M2x.floor, M2x.noise, M2x.hum, M2y.floor, M2y.noise, M2y.hum left out. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [3, 3, 3, 3] steps later.</p><p>Source: Laser beam pointing with four piezo axes and LS-SVM models; sections IV and V.</p></html>"));
  end P0Truth;

  block P1 "P-752.21C nanopositioning stage, linear"
    extends Icons.Rig;
    Interfaces.CommandInput u[1] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[1] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 0.0002 "Time between samples: the step of the blueprint";
    Piezoloop.Electrical.AmplifierLag amplifier1(bandwidth = 3000.0, gain = 10.0) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Blocks.Actuator.ActuatorGain actuator1(gain = 0.35, offset = 0.0) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Hold mechanics1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{-38,34},{-26,46}})));
    Piezoloop.Mechanics.Mode mechanics1(frequency = 2100.0, damping = 0.02, gain = 1.0) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
    Hold sensor1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{-8,34},{4,46}})));
    Piezoloop.Sensors.SensorLag sensor1(bandwidth = 10000.0) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Hold filter1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{22,34},{34,46}})));
    Piezoloop.Sensors.SensorButterworth filter1(bandwidth = 40.0, order = 1) annotation(Placement(transformation(extent={{32,32},{48,48}})));
  equation
    connect(u[1], amplifier1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(amplifier1.y, actuator1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(actuator1.y, mechanics1_hold.u) annotation(Line(points={{-44,40},{-38,40}}, color={0,0,127}));
    connect(mechanics1_hold.y, mechanics1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(mechanics1.y, sensor1_hold.u) annotation(Line(points={{-14,40},{-8,40}}, color={0,0,127}));
    connect(sensor1_hold.y, sensor1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(sensor1.y, filter1_hold.u) annotation(Line(points={{16,40},{22,40}}, color={0,0,127}));
    connect(filter1_hold.y, filter1.u) annotation(Line(points={{16,40},{30,40}}, color={0,0,127}));
    connect(filter1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p1</code>. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [3] steps later.</p><p>Source: LS-SVM with stop operators tuned by particle swarm, piezo stage P-752.21C; Tables 1 and 2.</p></html>"));
  end P1;

  block P1Truth "P-752.21C stage as a machine: Kuhnen hysteresis, creep, sensor"
    extends Icons.Rig;
    Interfaces.CommandInput u[1] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[1] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 0.0002 "Time between samples: the step of the blueprint";
    Piezoloop.Blocks.Timing.DacQuantisation dac1(resolution = 0.000305) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Electrical.AmplifierLag amplifier1(bandwidth = 3000.0, gain = 10.0) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Piezoloop.Hysteresis.ModifiedPrandtlIshlinskii hysteresis1(r = {0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0}, w = {0.32, 0.00265, 0.00265, 0.00265, 0.00265, 0.00071, 0.00071, 0.00071, 0.00071}, edge = {9.15, 16.25}, slope = {-0.294, 0.5645}, offset = 0.0, plays = 9, zones = 2, step = step) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep1(share = {0.004, 0.005, 0.006}, time_constant = {0.05, 0.5, 5.0}, elements = 3) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Hold mechanics1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{22,34},{34,46}})));
    Piezoloop.Mechanics.Mode mechanics1(frequency = 2100.0, damping = 0.02, gain = 1.0) annotation(Placement(transformation(extent={{32,32},{48,48}})));
    Hold sensor1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{52,34},{64,46}})));
    Piezoloop.Sensors.SensorLag sensor1(bandwidth = 10000.0) annotation(Placement(transformation(extent={{62,32},{78,48}})));
    Hold filter1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{82,34},{94,46}})));
    Piezoloop.Sensors.SensorButterworth filter1(bandwidth = 40.0, order = 1) annotation(Placement(transformation(extent={{92,32},{108,48}})));
  equation
    connect(u[1], dac1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(dac1.y, amplifier1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(amplifier1.y, hysteresis1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(hysteresis1.y, creep1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(creep1.y, mechanics1_hold.u) annotation(Line(points={{16,40},{22,40}}, color={0,0,127}));
    connect(mechanics1_hold.y, mechanics1.u) annotation(Line(points={{16,40},{30,40}}, color={0,0,127}));
    connect(mechanics1.y, sensor1_hold.u) annotation(Line(points={{46,40},{52,40}}, color={0,0,127}));
    connect(sensor1_hold.y, sensor1.u) annotation(Line(points={{46,40},{60,40}}, color={0,0,127}));
    connect(sensor1.y, filter1_hold.u) annotation(Line(points={{76,40},{82,40}}, color={0,0,127}));
    connect(filter1_hold.y, filter1.u) annotation(Line(points={{76,40},{90,40}}, color={0,0,127}));
    connect(filter1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p1-truth</code>. Without disturbances: x.noise left out. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [4] steps later.</p><p>Source: LS-SVM with stop operators tuned by particle swarm, piezo stage P-752.21C; parameters not in the paper are matched to its do-nothing errors.</p></html>"));
  end P1Truth;

  block P2 "Piezo bimorph, Bouc-Wen hysteresis in front of a lightly damped mode, as printed"
    extends Icons.Rig;
    Interfaces.CommandInput u[1] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[1] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 0.0001 "Time between samples: the step of the blueprint";
    Piezoloop.Hysteresis.BoucWen hysteresis1(gain = 24.373, alpha = 0.1947, beta = 3.3626, gamma = -2.8526, delta = 0.0, exponent = 1.0, offset = 0.0, step = step) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Mechanics.Mode mechanics1(frequency = 405.06, damping = 0.00036, gain = 1.0) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
  equation
    connect(u[1], hysteresis1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(hysteresis1.y, mechanics1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(mechanics1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p2</code>. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [0] steps later.</p><p>Source: LS-SVM hysteresis model without an inverse, piezo bimorph T434-A4-201; section IV.</p></html>"));
  end P2;

  block P2Truth "Piezo bimorph as a machine: plays that widen with the rate, creep, a light mode, laser sensor"
    extends Icons.Rig;
    Interfaces.CommandInput u[1] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[1] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 0.0001 "Time between samples: the step of the blueprint";
    Piezoloop.Electrical.AmplifierLag amplifier1(bandwidth = 1000.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Hysteresis.RateDependentPlay hysteresis1(r = {0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0}, w = {0.387799, 0.387799, 0.387799, 0.387799, 0.387799, 0.343683, 0.343683, 0.343683, 0.343683, 0.343683}, offset = 0.0, gain = 20.044423, rate = 0.176667, plays = 10, step = step) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep1(share = {0.002, 0.003, 0.00601}, time_constant = {0.1, 1.0, 10.0}, elements = 3) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
    Hold mechanics1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{-8,34},{4,46}})));
    Piezoloop.Mechanics.Mode mechanics1(frequency = 404.0, damping = 0.000363, gain = 1.0) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Hold sensor1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{22,34},{34,46}})));
    Piezoloop.Sensors.SensorLag sensor1(bandwidth = 5000.0) annotation(Placement(transformation(extent={{32,32},{48,48}})));
  equation
    connect(u[1], amplifier1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(amplifier1.y, hysteresis1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(hysteresis1.y, creep1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(creep1.y, mechanics1_hold.u) annotation(Line(points={{-14,40},{-8,40}}, color={0,0,127}));
    connect(mechanics1_hold.y, mechanics1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(mechanics1.y, sensor1_hold.u) annotation(Line(points={{16,40},{22,40}}, color={0,0,127}));
    connect(sensor1_hold.y, sensor1.u) annotation(Line(points={{16,40},{30,40}}, color={0,0,127}));
    connect(sensor1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p2-truth</code>. Without disturbances: tip.noise left out. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [3] steps later.</p><p>Source: LS-SVM hysteresis model without an inverse, piezo bimorph T434-A4-201; parameters not in the paper are matched to its Bouc-Wen errors.</p></html>"));
  end P2Truth;

  block P3 "P66X30 nanopositioning stage, linear"
    extends Icons.Rig;
    Interfaces.CommandInput u[1] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[1] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 5e-05 "Time between samples: the step of the blueprint";
    Piezoloop.Electrical.AmplifierLag amplifier1(bandwidth = 10000.0, gain = 15.0) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Blocks.Actuator.ActuatorGain actuator1(gain = 0.1768, offset = 0.0) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Hold mechanics1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{-38,34},{-26,46}})));
    Piezoloop.Mechanics.Mode mechanics1(frequency = 3000.0, damping = 0.5, gain = 1.0) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
  equation
    connect(u[1], amplifier1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(amplifier1.y, actuator1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(actuator1.y, mechanics1_hold.u) annotation(Line(points={{-44,40},{-38,40}}, color={0,0,127}));
    connect(mechanics1_hold.y, mechanics1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(mechanics1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p3</code>. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [1] steps later.</p><p>Source: Gaussian process with high-dimensional input, piezo stage P66X30; section V.</p></html>"));
  end P3;

  block P3Truth "P66X30 stage as a machine: hysteresis that widens with the rate, creep, strain gauge"
    extends Icons.Rig;
    Interfaces.CommandInput u[1] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[1] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 2.5e-05 "Time between samples: the step of the blueprint";
    Piezoloop.Electrical.AmplifierLag amplifier1(bandwidth = 10000.0, gain = 15.0) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Hysteresis.RateDependentPlay hysteresis1(r = {2.24, 4.48, 6.72, 8.96, 11.2, 13.44, 15.68, 17.92, 20.16, 22.4, 24.64, 26.88}, w = {0.0042, 0.0042, 0.0042, 0.0042, 0.0042, 0.0042, 0.0042, 0.0042, 0.0042, 0.0042, 0.0042, 0.0042}, offset = 0.0, gain = 0.157, rate = 2.55e-06, plays = 12, step = step) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep1(share = {0.0014, 0.0018, 0.0023}, time_constant = {0.05, 0.5, 5.0}, elements = 3) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
    Hold mechanics1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{-8,34},{4,46}})));
    Piezoloop.Mechanics.ModePair mechanics1(frequency = 3000.0, damping = 0.61, second_frequency = 450.0, second_damping = 0.155, share = -0.041) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Hold gauge1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{22,34},{34,46}})));
    Piezoloop.Sensors.SensorLag gauge1(bandwidth = 28000.0) annotation(Placement(transformation(extent={{32,32},{48,48}})));
  equation
    connect(u[1], amplifier1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(amplifier1.y, hysteresis1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(hysteresis1.y, creep1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(creep1.y, mechanics1_hold.u) annotation(Line(points={{-14,40},{-8,40}}, color={0,0,127}));
    connect(mechanics1_hold.y, mechanics1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(mechanics1.y, gauge1_hold.u) annotation(Line(points={{16,40},{22,40}}, color={0,0,127}));
    connect(gauge1_hold.y, gauge1.u) annotation(Line(points={{16,40},{30,40}}, color={0,0,127}));
    connect(gauge1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p3-truth</code>. Without disturbances: x.noise left out. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [3] steps later.</p><p>Source: Gaussian process with high-dimensional input, piezo stage P66X30; parameters not in the paper are matched to its PI loop.</p></html>"));
  end P3Truth;

  block Evc "Elliptical vibration cutting device with two parallel-flexure axes"
    extends Icons.Rig;
    Interfaces.CommandInput u[2] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[2] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 2e-05 "Time between samples: the step of the blueprint";
    Piezoloop.Electrical.AmplifierLag amplifier1(bandwidth = 3000.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Hysteresis.PrandtlIshlinskii hysteresis1(r = {0.0, 6.0, 12.0, 18.0, 24.0, 30.0, 36.0, 42.0, 48.0, 54.0}, w = {0.01354, 0.0279, 0.0, 0.004014, 0.007765, 0.0, 0.0, 0.0, 0.0, 0.0}, offset = 0.0, plays = 10, step = step) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Piezoloop.Mechanics.Mode mechanics1(frequency = 482.6, damping = 0.02, gain = 1.0) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
    Piezoloop.Electrical.AmplifierLag amplifier2(bandwidth = 3000.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,-28},{-72,-12}})));
    Piezoloop.Hysteresis.PrandtlIshlinskii hysteresis2(r = {0.0, 6.0, 12.0, 18.0, 24.0, 30.0, 36.0, 42.0, 48.0, 54.0}, w = {0.02523, 0.04579, 0.0, 0.004541, 0.001636, 0.0, 0.0, 0.0, 0.0, 0.0}, offset = 0.0, plays = 10, step = step) annotation(Placement(transformation(extent={{-58,-28},{-42,-12}})));
    Piezoloop.Mechanics.Mode mechanics2(frequency = 290.7, damping = 0.02, gain = 1.0) annotation(Placement(transformation(extent={{-28,-28},{-12,-12}})));
    Hold sensor1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{-8,34},{4,46}})));
    Piezoloop.Sensors.SensorLag sensor1(bandwidth = 10000.0) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Hold sensor2_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{-8,-26},{4,-14}})));
    Piezoloop.Sensors.SensorLag sensor2(bandwidth = 10000.0) annotation(Placement(transformation(extent={{2,-28},{18,-12}})));
  equation
    connect(u[1], amplifier1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(amplifier1.y, hysteresis1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(hysteresis1.y, mechanics1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(u[2], amplifier2.u) annotation(Line(points={{-104,-20},{-90,-20}}, color={0,0,127}));
    connect(amplifier2.y, hysteresis2.u) annotation(Line(points={{-74,-20},{-60,-20}}, color={0,0,127}));
    connect(hysteresis2.y, mechanics2.u) annotation(Line(points={{-44,-20},{-30,-20}}, color={0,0,127}));
    connect(mechanics1.y, sensor1_hold.u) annotation(Line(points={{-14,40},{-8,40}}, color={0,0,127}));
    connect(sensor1_hold.y, sensor1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(mechanics2.y, sensor2_hold.u) annotation(Line(points={{-14,-20},{-8,-20}}, color={0,0,127}));
    connect(sensor2_hold.y, sensor2.u) annotation(Line(points={{-14,-20},{0,-20}}, color={0,0,127}));
    connect(sensor1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    connect(sensor2.y, y[2]) annotation(Line(points={{100,-20},{110,-20}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>evc</code>. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [2, 2] steps later.</p><p>Source: C. Zhang, Z. Shu, Y. Yuan, X. Gan, F. Yu: Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated Elliptical Vibration Cutting Device, Tables 2 and 3, Figure 1.</p></html>"));
  end Evc;

  block P4Truth "Elliptical vibration cutting device as a machine: asymmetric saturating hysteresis, creep, weak modes, sensor noise"
    extends Icons.Rig;
    Interfaces.CommandInput u[2] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[2] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 2e-05 "Time between samples: the step of the blueprint";
    Piezoloop.Electrical.AmplifierLag amplifier1(bandwidth = 2600.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Hysteresis.GeneralisedPlay hysteresis1(r = {0.0, 4.0, 8.0, 12.0, 16.0, 22.0, 28.0, 36.0, 44.0, 54.0}, w = {0.03451, 0.008749, 0.004731, 0.002558, 0.001383, 0.0005499, 0.0002186, 6.392e-05, 1.869e-05, 4.018e-06}, offset = 1.995, left_a0 = 115.5, left_a1 = 0.008657, left_a2 = -0.4799, left_a3 = 0.0, right_a0 = 74.81, right_a1 = 0.01337, right_a2 = -0.7389, right_a3 = 6.433, plays = 10, step = step) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep1(share = {0.006, 0.005, 0.004}, time_constant = {0.03, 0.3, 3.0}, elements = 3) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
    Hold mechanics1_hold(u_start = -1.4376965898350468e-10, step = step) annotation(Placement(transformation(extent={{-8,34},{4,46}})));
    Piezoloop.Mechanics.ModePair mechanics1(frequency = 4000.0, damping = 0.05, second_frequency = 482.6, second_damping = 0.03, share = 0.0394724) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Piezoloop.Electrical.AmplifierLag amplifier2(bandwidth = 2600.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,-28},{-72,-12}})));
    Piezoloop.Hysteresis.GeneralisedPlay hysteresis2(r = {0.0, 4.0, 8.0, 12.0, 16.0, 22.0, 28.0, 36.0, 44.0, 54.0}, w = {0.07849, 0.0002351, 0.0002284, 0.000222, 0.0002157, 0.0002066, 0.0001979, 0.0001869, 0.0001765, 0.0001643}, offset = 4.236, left_a0 = 448.5, left_a1 = 0.00223, left_a2 = -0.1459, left_a3 = 0.0, right_a0 = 116.7, right_a1 = 0.008569, right_a2 = -0.5696, right_a3 = 6.852, plays = 10, step = step) annotation(Placement(transformation(extent={{-58,-28},{-42,-12}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep2(share = {0.006, 0.005, 0.004}, time_constant = {0.03, 0.3, 3.0}, elements = 3) annotation(Placement(transformation(extent={{-28,-28},{-12,-12}})));
    Hold mechanics2_hold(u_start = 5.069473665568758e-10, step = step) annotation(Placement(transformation(extent={{-8,-26},{4,-14}})));
    Piezoloop.Mechanics.ModePair mechanics2(frequency = 4000.0, damping = 0.05, second_frequency = 290.7, second_damping = 0.03, share = 0.01) annotation(Placement(transformation(extent={{2,-28},{18,-12}})));
    Hold sensor1_hold(u_start = -1.4376965898350468e-10, step = step) annotation(Placement(transformation(extent={{22,34},{34,46}})));
    Piezoloop.Sensors.SensorLag sensor1(bandwidth = 8000.0) annotation(Placement(transformation(extent={{32,32},{48,48}})));
    Hold sensor2_hold(u_start = 5.069473665568758e-10, step = step) annotation(Placement(transformation(extent={{22,-26},{34,-14}})));
    Piezoloop.Sensors.SensorLag sensor2(bandwidth = 8000.0) annotation(Placement(transformation(extent={{32,-28},{48,-12}})));
  equation
    connect(u[1], amplifier1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(amplifier1.y, hysteresis1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(hysteresis1.y, creep1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(creep1.y, mechanics1_hold.u) annotation(Line(points={{-14,40},{-8,40}}, color={0,0,127}));
    connect(mechanics1_hold.y, mechanics1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(u[2], amplifier2.u) annotation(Line(points={{-104,-20},{-90,-20}}, color={0,0,127}));
    connect(amplifier2.y, hysteresis2.u) annotation(Line(points={{-74,-20},{-60,-20}}, color={0,0,127}));
    connect(hysteresis2.y, creep2.u) annotation(Line(points={{-44,-20},{-30,-20}}, color={0,0,127}));
    connect(creep2.y, mechanics2_hold.u) annotation(Line(points={{-14,-20},{-8,-20}}, color={0,0,127}));
    connect(mechanics2_hold.y, mechanics2.u) annotation(Line(points={{-14,-20},{0,-20}}, color={0,0,127}));
    connect(mechanics1.y, sensor1_hold.u) annotation(Line(points={{16,40},{22,40}}, color={0,0,127}));
    connect(sensor1_hold.y, sensor1.u) annotation(Line(points={{16,40},{30,40}}, color={0,0,127}));
    connect(mechanics2.y, sensor2_hold.u) annotation(Line(points={{16,-20},{22,-20}}, color={0,0,127}));
    connect(sensor2_hold.y, sensor2.u) annotation(Line(points={{16,-20},{30,-20}}, color={0,0,127}));
    connect(sensor1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    connect(sensor2.y, y[2]) annotation(Line(points={{100,-20},{110,-20}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p4-truth</code>. Without disturbances: Y.noise, Z.noise left out. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [3, 3] steps later.</p><p>Source: C. Zhang, Z. Shu, Y. Yuan, X. Gan, F. Yu: Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated Elliptical Vibration Cutting Device; parameters not in the paper are matched to its static model or assumed.</p></html>"));
  end P4Truth;

  block EvcTruth "Elliptical vibration cutting device as a machine: asymmetric hysteresis, creep, sensor noise"
    extends Icons.Rig;
    Interfaces.CommandInput u[2] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[2] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 2e-05 "Time between samples: the step of the blueprint";
    Piezoloop.Electrical.AmplifierLag amplifier1(bandwidth = 2600.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Hysteresis.BoucWen hysteresis1(gain = 0.0535, alpha = 0.4, beta = 0.03, gamma = 0.015, delta = 0.004, exponent = 1.0, offset = 0.0, step = step) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep1(share = {0.006, 0.005, 0.004}, time_constant = {0.03, 0.3, 3.0}, elements = 3) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
    Hold mechanics1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{-8,34},{4,46}})));
    Piezoloop.Mechanics.Mode mechanics1(frequency = 470.0, damping = 0.025, gain = 1.0) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Piezoloop.Electrical.AmplifierLag amplifier2(bandwidth = 2600.0, gain = 1.0) annotation(Placement(transformation(extent={{-88,-28},{-72,-12}})));
    Piezoloop.Hysteresis.BoucWen hysteresis2(gain = 0.0775, alpha = 0.2945, beta = 0.037, gamma = 0.018, delta = 0.005, exponent = 1.0, offset = 0.0, step = step) annotation(Placement(transformation(extent={{-58,-28},{-42,-12}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep2(share = {0.006, 0.005, 0.004}, time_constant = {0.03, 0.3, 3.0}, elements = 3) annotation(Placement(transformation(extent={{-28,-28},{-12,-12}})));
    Hold mechanics2_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{-8,-26},{4,-14}})));
    Piezoloop.Mechanics.Mode mechanics2(frequency = 284.0, damping = 0.022, gain = 1.0) annotation(Placement(transformation(extent={{2,-28},{18,-12}})));
    Hold sensor1_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{22,34},{34,46}})));
    Piezoloop.Sensors.SensorLag sensor1(bandwidth = 8000.0) annotation(Placement(transformation(extent={{32,32},{48,48}})));
    Hold sensor2_hold(u_start = 0.0, step = step) annotation(Placement(transformation(extent={{22,-26},{34,-14}})));
    Piezoloop.Sensors.SensorLag sensor2(bandwidth = 8000.0) annotation(Placement(transformation(extent={{32,-28},{48,-12}})));
  equation
    connect(u[1], amplifier1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(amplifier1.y, hysteresis1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(hysteresis1.y, creep1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(creep1.y, mechanics1_hold.u) annotation(Line(points={{-14,40},{-8,40}}, color={0,0,127}));
    connect(mechanics1_hold.y, mechanics1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(u[2], amplifier2.u) annotation(Line(points={{-104,-20},{-90,-20}}, color={0,0,127}));
    connect(amplifier2.y, hysteresis2.u) annotation(Line(points={{-74,-20},{-60,-20}}, color={0,0,127}));
    connect(hysteresis2.y, creep2.u) annotation(Line(points={{-44,-20},{-30,-20}}, color={0,0,127}));
    connect(creep2.y, mechanics2_hold.u) annotation(Line(points={{-14,-20},{-8,-20}}, color={0,0,127}));
    connect(mechanics2_hold.y, mechanics2.u) annotation(Line(points={{-14,-20},{0,-20}}, color={0,0,127}));
    connect(mechanics1.y, sensor1_hold.u) annotation(Line(points={{16,40},{22,40}}, color={0,0,127}));
    connect(sensor1_hold.y, sensor1.u) annotation(Line(points={{16,40},{30,40}}, color={0,0,127}));
    connect(mechanics2.y, sensor2_hold.u) annotation(Line(points={{16,-20},{22,-20}}, color={0,0,127}));
    connect(sensor2_hold.y, sensor2.u) annotation(Line(points={{16,-20},{30,-20}}, color={0,0,127}));
    connect(sensor1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    connect(sensor2.y, y[2]) annotation(Line(points={{100,-20},{110,-20}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>evc-truth</code>. Without disturbances: Y.noise, Z.noise left out. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [3, 3] steps later.</p><p>Source: C. Zhang, Z. Shu, Y. Yuan, X. Gan, F. Yu: Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated Elliptical Vibration Cutting Device; parameters not in the paper are assumed.</p></html>"));
  end EvcTruth;

  block P885 "PI P-885.91 stack in an amplified flexure: delay, curved Prandtl-Ishlinskii hysteresis, creep"
    extends Icons.Rig;
    Interfaces.CommandInput u[1] "Commands" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[1] "Positions" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    parameter Real step(unit="s", min = 0) = 0.005 "Time between samples: the step of the blueprint";
    Piezoloop.Blocks.Timing.Delay delay1(delay_ = 0.010608507499113615, longest = 0.025, cells = 7, step = step) annotation(Placement(transformation(extent={{-88,32},{-72,48}})));
    Piezoloop.Electrical.AmplifierNonlinearity nonlinearity1(offset = 0.0, quadratic = 0.1101852387357348, cubic = 0.0, centre = 1.8, half_range = 1.8) annotation(Placement(transformation(extent={{-58,32},{-42,48}})));
    Piezoloop.Hysteresis.PrandtlIshlinskii hysteresis1(r = {0.0, 0.030000000000000002, 0.060000000000000005, 0.09000000000000001, 0.12000000000000001, 0.15000000000000002, 0.18000000000000002, 0.21000000000000002, 0.24000000000000002, 0.27, 0.3, 0.33, 0.36000000000000004, 0.39, 0.42, 0.45, 0.48000000000000004, 0.51, 0.5399999999999999, 0.57, 0.6, 0.63, 0.66, 0.6900000000000001, 0.7200000000000001, 0.75, 0.78, 0.81, 0.84, 0.87, 0.9, 0.93, 0.9600000000000001, 0.99, 1.02, 1.0499999999999998, 1.0799999999999998, 1.1099999999999999, 1.1400000000000001, 1.17, 1.2, 1.23, 1.2600000000000002, 1.29, 1.32, 1.35, 1.38, 1.4100000000000001, 1.4400000000000002, 1.4700000000000002, 1.5, 1.53, 1.56, 1.59, 1.62, 1.65, 1.68, 1.71, 1.74, 1.77}, w = {8.921949521940022, 0.15892392556984633, 0.15692868269514965, 0.1549334411305813, 0.1529382042777748, 0.15094297810680024, 0.1489477713907236, 0.1469525957949649, 0.14495746586966554, 0.14296239891376541, 0.1409674147279375, 0.13897253527097006, 0.13697778422952261, 0.13498318650387175, 0.1329887676567242, 0.13099455331958187, 0.12900056855113365, 0.1270068371895392, 0.1250133812370244, 0.12302022023737418, 0.12102737075178141, 0.11903484593810153, 0.1170426552230152, 0.11505080410947333, 0.11305929408882753, 0.11106812269555527, 0.10907728369841567, 0.10708676743300734, 0.10509656122324573, 0.10310664988472515, 0.10111701628703533, 0.09912764193966482, 0.09713850757677474, 0.09514959372722985, 0.09316088124051815, 0.09117235173726865, 0.08918398796826268, 0.0871957740745081, 0.08520769573511316, 0.08321974022937341, 0.08123189638206697, 0.07924415442917228, 0.07725650585066383, 0.0752689431593519, 0.07328145969116076, 0.07129404940779559, 0.0693067066764099, 0.06731942604797167, 0.06533220208252216, 0.0633450291995245, 0.061357901586169154, 0.0593708132205187, 0.05738375792571595, 0.055396729482134845, 0.053409721810113414, 0.051422729206440525, 0.049435746613910404, 0.04744876984781762, 0.04546179578552508, 0.043474822499930905}, offset = -118.01635534287382, u_start = 0.19833342972432264, plays = 60, step = step) annotation(Placement(transformation(extent={{-28,32},{-12,48}})));
    Piezoloop.Blocks.Creep.KelvinVoigtCreep creep1(share = {0.017018860019411167, 0.017018860019411167, 0.017018860019411167}, time_constant = {0.090325, 0.9032500000000001, 9.0325}, elements = 3) annotation(Placement(transformation(extent={{2,32},{18,48}})));
    Piezoloop.Sensors.SensorPolynomial linearity1(quadratic = -0.16328091679672915, cubic = 0.03727044114132387, centre = -96.474505, half_range = 22.753695) annotation(Placement(transformation(extent={{32,32},{48,48}})));
  equation
    connect(u[1], delay1.u) annotation(Line(points={{-104,40},{-90,40}}, color={0,0,127}));
    connect(delay1.y, nonlinearity1.u) annotation(Line(points={{-74,40},{-60,40}}, color={0,0,127}));
    connect(nonlinearity1.y, hysteresis1.u) annotation(Line(points={{-44,40},{-30,40}}, color={0,0,127}));
    connect(hysteresis1.y, creep1.u) annotation(Line(points={{-14,40},{0,40}}, color={0,0,127}));
    connect(creep1.y, linearity1.u) annotation(Line(points={{16,40},{30,40}}, color={0,0,127}));
    connect(linearity1.y, y[1]) annotation(Line(points={{100,40},{110,40}}, color={0,0,127}));
    annotation(Documentation(info="<html><p>Rig <code>p885</code>. Blocks that run once per step answer a step later than in the FMU: y[i] is the FMU's position [0] steps later.</p><p>Source: identified from model_1hz_3v6.csv; Y. N. Aye, W. T. Ang, ICSTSD Yangon 2018.</p></html>"));
  end P885;
  annotation(Documentation(info="<html><p>Nominal and truth rigs of the tool.</p></html>"));
end Rigs;

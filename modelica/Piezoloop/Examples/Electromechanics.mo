within Piezoloop.Examples;
package Electromechanics "Chains with pins and flanges, with their energy balance"
  extends Icons.ExamplesPackage;

  model StackWithPayload "Amplifier, stack, payload: as pins and flanges, and as blocks"
    extends Icons.Example;
    Sources.Wave wave(amplitude = {20, 5}, frequency = {60, 170}, step = 1e-4) annotation(Placement(transformation(extent={{-100,40},{-80,60}})));
    Piezoloop.Electrical.Analog.Amplifier amplifier(resistance = 20, current = 0.1) annotation(Placement(transformation(extent={{-60,40},{-40,60}})));
    Piezoloop.Electrical.Analog.Ground ground annotation(Placement(transformation(extent={{-40,-20},{-20,0}})));
    Piezoloop.Electrical.Analog.PiezoStack stack(stiffness = 4e6, stroke_per_volt = 1e-7, capacitance = 2e-6, damping = 60) annotation(Placement(transformation(extent={{-20,40},{0,60}})));
    Piezoloop.Mechanics.Translational.Fixed base annotation(Placement(transformation(extent={{-30,20},{-10,40}})));
    Piezoloop.Mechanics.Translational.Mass payload(m = 0.3) annotation(Placement(transformation(extent={{20,34},{40,54}})));
    Piezoloop.Mechanics.Translational.PositionSensor sensor annotation(Placement(transformation(extent={{60,34},{80,54}})));
    Piezoloop.Electrical.AmplifierRc amplifier_block(resistance = 20, current = 0.1, capacitance = 2e-6, transduction = 4e6*1e-7*1e-6) annotation(Placement(transformation(extent={{-60,-80},{-40,-60}})));
    Piezoloop.Blocks.Actuator.ActuatorGain gain_block(gain = 0.1) annotation(Placement(transformation(extent={{-20,-80},{0,-60}})));
    Piezoloop.Mechanics.LoadedMode mode_block(frequency = sqrt(4e6/0.3)/(2*Constants.pi), damping = 60/(2*sqrt(4e6*0.3)), mass = 0.3) annotation(Placement(transformation(extent={{20,-80},{40,-60}})));
    Types.Position difference "Flanges less blocks";
    Types.Energy balance "Energy delivered less stored and lost: zero";
  equation
    connect(wave.y, amplifier.u) annotation(Line(points={{-79,50},{-60,50}}, color={0,0,127}));
    connect(amplifier.p, stack.p) annotation(Line(points={{-40,56},{-30,56},{-30,50},{-20,50}}, color={0,0,255}));
    connect(amplifier.n, stack.n) annotation(Line(points={{-40,44},{-36,44},{-36,66},{10,66},{10,50},{0,50}}, color={0,0,255}));
    connect(amplifier.n, ground.p) annotation(Line(points={{-40,44},{-30,44},{-30,0}}, color={0,0,255}));
    connect(base.flange, stack.flange_a) annotation(Line(points={{-20,30},{-20,44}}, color={0,127,0}));
    connect(stack.flange_b, payload.flange_a) annotation(Line(points={{0,44},{20,44}}, color={0,127,0}));
    connect(payload.flange_b, sensor.flange) annotation(Line(points={{40,44},{60,44}}, color={0,127,0}));
    connect(wave.y, amplifier_block.u) annotation(Line(points={{-79,50},{-70,50},{-70,-70},{-64,-70}}, color={0,0,127}));
    connect(amplifier_block.y, gain_block.u) annotation(Line(points={{-39,-70},{-24,-70}}, color={0,0,127}));
    connect(gain_block.y, mode_block.u) annotation(Line(points={{1,-70},{16,-70}}, color={0,0,127}));
    connect(mode_block.y, amplifier_block.displacement) annotation(Line(points={{41,-70},{60,-70},{60,-95},{-50,-95},{-50,-82}}, color={0,0,127}));
    difference = sensor.y - mode_block.y;
    balance = amplifier.delivered - stack.stored - stack.dissipated - payload.stored;
    annotation(experiment(StartTime=0, StopTime=0.03, Interval=1e-4, Tolerance=1e-9),
      Documentation(info="<html><p>The same machine twice. <code>difference</code> and <code>balance</code> stay at the solver's tolerance.</p></html>"));
  end StackWithPayload;

  model StageWithFriction "Stack, clearance, flexure-guided stage with dry friction, and a force on it"
    extends Icons.Example;
    Sources.Wave wave(amplitude = {30}, frequency = {40}, step = 1e-4) annotation(Placement(transformation(extent={{-100,30},{-80,50}})));
    Sources.Wave push(scale = 0.5, amplitude = {2}, frequency = {25}, step = 1e-4) annotation(Placement(transformation(extent={{-100,-60},{-80,-40}})));
    Piezoloop.Electrical.Analog.Amplifier amplifier(resistance = 50, current = 0.2) annotation(Placement(transformation(extent={{-70,30},{-50,50}})));
    Piezoloop.Electrical.Analog.Ground ground annotation(Placement(transformation(extent={{-50,0},{-30,20}})));
    Piezoloop.Electrical.Analog.PiezoStack stack(stiffness = 2e7, stroke_per_volt = 1.5e-7, capacitance = 2e-6, damping = 300) annotation(Placement(transformation(extent={{-40,30},{-20,50}})));
    Piezoloop.Mechanics.Translational.Fixed base annotation(Placement(transformation(extent={{-50,-30},{-30,-10}})));
    Piezoloop.Mechanics.Translational.Mass tip(m = 0.02) annotation(Placement(transformation(extent={{-14,24},{6,44}})));
    Piezoloop.Mechanics.Translational.Clearance gap(width = 2e-7, stiffness = 5e7) annotation(Placement(transformation(extent={{12,24},{32,44}})));
    Piezoloop.Mechanics.Translational.Mass stage(m = 0.2) annotation(Placement(transformation(extent={{38,24},{58,44}})));
    Piezoloop.Mechanics.Translational.Flexure flexure(stiffness = 1e6, cubic = 1e16, damping = 150) annotation(Placement(transformation(extent={{12,-20},{32,0}})));
    Piezoloop.Mechanics.Translational.Friction friction(coulomb = 1, presliding = 2e-7, viscous = 1) annotation(Placement(transformation(extent={{12,-50},{32,-30}})));
    Piezoloop.Mechanics.Translational.Force force annotation(Placement(transformation(extent={{-40,-90},{-20,-70}})));
    Piezoloop.Mechanics.Translational.PositionSensor sensor annotation(Placement(transformation(extent={{70,24},{90,44}})));
    Types.Energy balance "Energy delivered less stored and lost: zero";
  equation
    connect(wave.y, amplifier.u) annotation(Line(points={{-79,40},{-70,40}}, color={0,0,127}));
    connect(amplifier.p, stack.p) annotation(Line(points={{-50,46},{-45,46},{-45,40},{-40,40}}, color={0,0,255}));
    connect(amplifier.n, stack.n) annotation(Line(points={{-50,34},{-46,34},{-46,56},{-16,56},{-16,40},{-20,40}}, color={0,0,255}));
    connect(amplifier.n, ground.p) annotation(Line(points={{-50,34},{-40,34},{-40,20}}, color={0,0,255}));
    connect(base.flange, stack.flange_a) annotation(Line(points={{-40,-20},{-44,-20},{-44,34},{-40,34}}, color={0,127,0}));
    connect(stack.flange_b, tip.flange_a) annotation(Line(points={{-20,34},{-14,34}}, color={0,127,0}));
    connect(tip.flange_b, gap.flange_a) annotation(Line(points={{6,34},{12,34}}, color={0,127,0}));
    connect(gap.flange_b, stage.flange_a) annotation(Line(points={{32,34},{38,34}}, color={0,127,0}));
    connect(base.flange, flexure.flange_a) annotation(Line(points={{-40,-20},{0,-20},{0,-10},{12,-10}}, color={0,127,0}));
    connect(base.flange, friction.flange_a) annotation(Line(points={{-40,-20},{0,-20},{0,-40},{12,-40}}, color={0,127,0}));
    connect(flexure.flange_b, stage.flange_b) annotation(Line(points={{32,-10},{62,-10},{62,34},{58,34}}, color={0,127,0}));
    connect(friction.flange_b, stage.flange_b) annotation(Line(points={{32,-40},{62,-40},{62,34},{58,34}}, color={0,127,0}));
    connect(push.y, force.f) annotation(Line(points={{-79,-50},{-60,-50},{-60,-80},{-40,-80}}, color={0,127,0}));
    connect(force.flange, stage.flange_b) annotation(Line(points={{-20,-80},{62,-80},{62,34},{58,34}}, color={0,127,0}));
    connect(stage.flange_b, sensor.flange) annotation(Line(points={{58,34},{70,34}}, color={0,127,0}));
    balance = amplifier.delivered + force.delivered - stack.stored - stack.dissipated - tip.stored - gap.stored - stage.stored
      - flexure.stored - flexure.dissipated - friction.stored - friction.dissipated;
    annotation(experiment(StartTime=0, StopTime=0.05, Interval=1e-4, Tolerance=1e-9),
      Documentation(info="<html><p>All components with flanges in one machine. <code>balance</code> stays at the solver's tolerance.</p></html>"));
  end StageWithFriction;
  annotation(Documentation(info="<html><p>Examples of <code>Electrical.Analog</code> and <code>Mechanics.Translational</code>.</p></html>"));
end Electromechanics;

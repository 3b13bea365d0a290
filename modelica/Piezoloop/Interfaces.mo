within Piezoloop;
package Interfaces "Connectors and what the blocks of a signal path share"
  extends Icons.InterfacesPackage;
  connector CommandInput = input Types.Command "Command, in V" annotation(
    Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,0,127}, fillColor={0,0,127}, fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,0,127}, fillColor={0,0,127}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html><p>Command, in V.</p></html>"));
  connector CommandOutput = output Types.Command "Command, in V" annotation(
    Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,0,127}, fillColor={255,255,255}, fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,0,127}, fillColor={255,255,255}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html><p>Command, in V.</p></html>"));
  connector PositionInput = input Types.Position "Position, in m" annotation(
    Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,114,178}, fillColor={0,114,178}, fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,114,178}, fillColor={0,114,178}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html><p>Position, in m.</p></html>"));
  connector PositionOutput = output Types.Position "Position, in m" annotation(
    Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,114,178}, fillColor={255,255,255}, fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,114,178}, fillColor={255,255,255}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html><p>Position, in m.</p></html>"));
  connector ForceInput = input Types.Force "Force, in N" annotation(
    Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,127,0}, fillColor={0,127,0}, fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,127,0}, fillColor={0,127,0}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html><p>Force, in N.</p></html>"));
  connector TemperatureInput = input Types.Temperature "Temperature, in K" annotation(
    Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={191,0,0}, fillColor={191,0,0}, fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={191,0,0}, fillColor={191,0,0}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html><p>Temperature, in K.</p></html>"));
  connector NoiseInput = input Real(unit="1") "Independent normal number of each step" annotation(
    Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={127,127,127}, fillColor={127,127,127}, fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={127,127,127}, fillColor={127,127,127}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html><p>Independent normal number of each step.</p></html>"));
  connector SignalInput = input Real "Signal of any unit" annotation(
    Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,0,127}, fillColor={0,0,127}, fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,0,127}, fillColor={0,0,127}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html><p>Signal of any unit.</p></html>"));
  connector SignalOutput = output Real "Signal of any unit" annotation(
    Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,0,127}, fillColor={255,255,255}, fillPattern=FillPattern.Solid)}),
    Diagram(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Polygon(points={{-100,100},{100,0},{-100,-100}}, lineColor={0,0,127}, fillColor={255,255,255}, fillPattern=FillPattern.Solid)}),
    Documentation(info="<html><p>Signal of any unit.</p></html>"));

  connector Flange_a "Left flange: position and force"
    Types.Position s "Absolute position of the flange";
    flow Types.Force f "Force into the component";
    annotation(
      Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Rectangle(extent={{-100,-100},{100,100}}, lineColor={0,127,0}, fillColor={0,127,0}, fillPattern=FillPattern.Solid)}),
      Documentation(info="<html><p>Position and force along one axis. The variables are those of <code>Modelica.Mechanics.Translational.Interfaces.Flange_a</code>, so the two may be connected.</p></html>"));
  end Flange_a;

  connector Flange_b "Right flange: position and force"
    Types.Position s "Absolute position of the flange";
    flow Types.Force f "Force into the component";
    annotation(
      Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Rectangle(extent={{-100,-100},{100,100}}, lineColor={0,127,0}, fillColor={255,255,255}, fillPattern=FillPattern.Solid)}),
      Documentation(info="<html><p>Position and force along one axis. The variables are those of <code>Modelica.Mechanics.Translational.Interfaces.Flange_b</code>, so the two may be connected.</p></html>"));
  end Flange_b;

  connector PositivePin "Positive pin"
    Types.Command v "Potential at the pin";
    flow Types.Current i "Current into the component";
    annotation(
      Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Rectangle(extent={{-100,-100},{100,100}}, lineColor={0,0,255}, fillColor={0,0,255}, fillPattern=FillPattern.Solid)}),
      Documentation(info="<html><p>Potential and current. The variables are those of <code>Modelica.Electrical.Analog.Interfaces.PositivePin</code>, so the two may be connected.</p></html>"));
  end PositivePin;

  connector NegativePin "Negative pin"
    Types.Command v "Potential at the pin";
    flow Types.Current i "Current into the component";
    annotation(
      Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={Rectangle(extent={{-100,-100},{100,100}}, lineColor={0,0,255}, fillColor={255,255,255}, fillPattern=FillPattern.Solid)}),
      Documentation(info="<html><p>Potential and current. The variables are those of <code>Modelica.Electrical.Analog.Interfaces.NegativePin</code>, so the two may be connected.</p></html>"));
  end NegativePin;

  partial block CommandFilter "Command to command"
    extends Icons.Block;
    CommandInput u "Command in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    CommandOutput y "Command behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    annotation(Documentation(info="<html><p>Command to command: one input <code>u</code>, one output <code>y</code>.</p></html>"));
  end CommandFilter;

  partial block Actuator "Command to position"
    extends Icons.Block;
    CommandInput u "Command" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    PositionOutput y "Position" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    Real y_um(unit="um") "Position, in um";
  equation
    y = Constants.um*y_um;
    annotation(Documentation(info="<html><p>Command to position: one input <code>u</code>, one output <code>y</code>.</p></html>"));
  end Actuator;

  partial block PositionFilter "Position to position"
    extends Icons.Block;
    PositionInput u "Position in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    PositionOutput y "Position behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    Real u_um(unit="um") = u/Constants.um "Position in front, in um";
    Real y_um(unit="um") "Position behind, in um";
  equation
    y = Constants.um*y_um;
    annotation(Documentation(info="<html><p>Position to position: one input <code>u</code>, one output <code>y</code>.</p></html>"));
  end PositionFilter;

  partial block Inverse "Wanted position to command"
    extends Icons.Block;
    PositionInput u "Wanted position" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    CommandOutput y "Command" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    Real u_um(unit="um") = u/Constants.um "Wanted position, in um";
    annotation(Documentation(info="<html><p>Wanted position to command: one input <code>u</code>, one output <code>y</code>.</p></html>"));
  end Inverse;

  partial block ReferenceFilter "Reference to reference"
    extends Icons.Block;
    PositionInput u "Reference" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    PositionOutput y "Reference with its lead" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    Real u_um(unit="um") = u/Constants.um "Reference, in um";
    Real y_um(unit="um") "Reference with its lead, in um";
  equation
    y = Constants.um*y_um;
    annotation(Documentation(info="<html><p>Reference to reference: one input <code>u</code>, one output <code>y</code>.</p></html>"));
  end ReferenceFilter;

  partial block PathFilter "Filter of a controller's path, of a reference or a command"
    extends Icons.Block;
    SignalInput u "Signal in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    SignalOutput y "Signal behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    annotation(Documentation(info="<html><p>Filter of a controller's path, of a reference or a command: one input <code>u</code>, one output <code>y</code>.</p></html>"));
  end PathFilter;

  partial block Controller "Feedforward to command"
    extends Icons.Block;
    CommandInput u "Feedforward" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    CommandOutput y "Command" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    annotation(Documentation(info="<html><p>Feedforward to command: one input <code>u</code>, one output <code>y</code>.</p></html>"));
  end Controller;

  partial model TwoFlanges "Component with two flanges along one axis"
    Flange_a flange_a "Left flange" annotation(Placement(transformation(extent={{-110,-10},{-90,10}})));
    Flange_b flange_b "Right flange" annotation(Placement(transformation(extent={{90,-10},{110,10}})));
    annotation(Icon(graphics={Line(points={{-90,0},{90,0}}, color={0,127,0})}), Documentation(info="<html><p>Two flanges. The force of a flange counts into the component.</p></html>"));
  end TwoFlanges;

  partial model TwoPins "Component with two pins and one current"
    PositivePin p "Positive pin" annotation(Placement(transformation(extent={{-110,-10},{-90,10}})));
    NegativePin n "Negative pin" annotation(Placement(transformation(extent={{90,-10},{110,10}})));
    Types.Command v "Voltage between the pins";
    Types.Current i "Current from p to n";
  equation
    v = p.v - n.v;
    i = p.i;
    p.i + n.i = 0;
    annotation(Icon(graphics={Line(points={{-90,0},{90,0}}, color={0,0,255})}), Documentation(info="<html><p>Two pins that carry the same current.</p></html>"));
  end TwoPins;
  annotation(Documentation(info="<html><p>Connectors and what the blocks of a signal path share.</p></html>"));
end Interfaces;

package Piezoloop "Piezo-actuated machines: plant components, controllers, known machines"
  extends Icons.Package;
  annotation(
    version = "0.1.0",
    preferredView = "info",
    Icon(graphics={
      Rectangle(extent={{-80,-30},{-70,30}}, lineColor={0,0,0}, fillColor={128,128,128}, fillPattern=FillPattern.Solid),
      Rectangle(extent={{-70,-20},{10,20}}, lineColor={0,0,0}, fillColor={230,159,0}, fillPattern=FillPattern.Solid),
      Line(points={{-50,-20},{-50,20}}), Line(points={{-30,-20},{-30,20}}), Line(points={{-10,-20},{-10,20}}),
      Line(points={{20,-40},{40,-20},{50,20},{70,40},{60,0},{40,-35},{20,-40}}, color={0,0,127}, smooth=Smooth.Bezier)}),
    Documentation(info="<html>
<p>One block per component of <code>piezoloop list models</code>, with the same names, bounds and start values: a blueprint's
numbers can be copied. Connectors are in SI units. <code>Electrical.Analog</code> and <code>Mechanics.Translational</code> have pins and flanges
that can be connected with those of the Modelica Standard Library, which is not needed. Begin with <code>UsersGuide</code>.</p>
</html>"));
end Piezoloop;

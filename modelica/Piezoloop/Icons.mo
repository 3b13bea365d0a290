within Piezoloop;
package Icons "Shapes that classes of the library share"
  extends Icons.Package;
  extends Package;

  partial class Package "Package"
    annotation(Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={
      Rectangle(extent={{-100,-100},{100,100}}, radius=25, lineColor={128,128,128}, fillColor={248,248,248}, fillPattern=FillPattern.Solid)}),
      Documentation(info="<html><p>Frame of a package.</p></html>"));
  end Package;

  partial class InterfacesPackage "Package of connectors"
    extends Package;
    annotation(Icon(graphics={
      Polygon(points={{-80,40},{-20,0},{-80,-40}}, lineColor={0,0,127}, fillColor={0,0,127}, fillPattern=FillPattern.Solid),
      Polygon(points={{20,40},{80,0},{20,-40}}, lineColor={0,0,127}, fillColor={255,255,255}, fillPattern=FillPattern.Solid)}),
      Documentation(info="<html><p>Frame of a package of connectors.</p></html>"));
  end InterfacesPackage;

  partial class TypesPackage "Package of quantities"
    extends Package;
    annotation(Icon(graphics={Text(extent={{-80,-60},{80,60}}, textString="SI", textColor={0,0,0})}),
      Documentation(info="<html><p>Frame of a package of quantities.</p></html>"));
  end TypesPackage;

  partial class ExamplesPackage "Package of examples"
    extends Package;
    annotation(Icon(graphics={
      Polygon(points={{-40,60},{-40,-60},{60,0}}, lineColor={0,158,115}, fillColor={0,158,115}, fillPattern=FillPattern.Solid)}),
      Documentation(info="<html><p>Frame of a package of examples.</p></html>"));
  end ExamplesPackage;

  partial class Function "Function"
    annotation(Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={
      Ellipse(extent={{-100,-100},{100,100}}, lineColor={108,88,49}, fillColor={255,215,136}, fillPattern=FillPattern.Solid),
      Text(extent={{-60,-50},{60,50}}, textString="f", textColor={108,88,49}),
      Text(extent={{-150,110},{150,150}}, textString="%name", textColor={0,0,255})}),
      Documentation(info="<html><p>Frame of a function.</p></html>"));
  end Function;

  partial class Record "Record of parameters"
    annotation(Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={
      Rectangle(extent={{-100,-80},{100,60}}, radius=20, lineColor={64,64,64}, fillColor={255,215,136}, fillPattern=FillPattern.Solid),
      Line(points={{-100,10},{100,10}}, color={64,64,64}), Line(points={{-100,-35},{100,-35}}, color={64,64,64}), Line(points={{0,60},{0,-80}}, color={64,64,64}),
      Text(extent={{-150,70},{150,110}}, textString="%name", textColor={0,0,255})}),
      Documentation(info="<html><p>Frame of a record.</p></html>"));
  end Record;

  partial class Example "Example that can be simulated"
    annotation(Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={
      Ellipse(extent={{-100,-100},{100,100}}, lineColor={75,138,73}, fillColor={255,255,255}, fillPattern=FillPattern.Solid),
      Polygon(points={{-36,60},{-36,-60},{64,0}}, lineColor={75,138,73}, fillColor={75,138,73}, fillPattern=FillPattern.Solid)}),
      Documentation(info="<html><p>Frame of an example.</p></html>"));
  end Example;

  partial class Information "Text for readers"
    annotation(Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={
      Ellipse(extent={{-100,-100},{100,100}}, lineColor={75,138,73}, fillColor={75,138,73}, fillPattern=FillPattern.Solid),
      Text(extent={{-60,-70},{60,70}}, textString="i", textColor={255,255,255})}),
      Documentation(info="<html><p>Frame of a page of the user's guide.</p></html>"));
  end Information;

  partial class Block "Block of a signal path"
    annotation(Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={
      Rectangle(extent={{-100,-100},{100,100}}, lineColor={0,0,127}, fillColor={255,255,255}, fillPattern=FillPattern.Solid),
      Text(extent={{-150,110},{150,150}}, textString="%name", textColor={0,0,255})}),
      Documentation(info="<html><p>Frame of a block.</p></html>"));
  end Block;

  partial class Rig "Known machine"
    annotation(Icon(coordinateSystem(extent={{-100,-100},{100,100}}), graphics={
      Rectangle(extent={{-100,-100},{100,100}}, lineColor={0,0,127}, fillColor={240,240,240}, fillPattern=FillPattern.Solid),
      Rectangle(extent={{-80,-60},{-70,60}}, lineColor={0,0,0}, fillColor={128,128,128}, fillPattern=FillPattern.Solid),
      Rectangle(extent={{-70,-15},{10,15}}, lineColor={0,0,0}, fillColor={230,159,0}, fillPattern=FillPattern.Solid),
      Line(points={{-50,-15},{-50,15}}), Line(points={{-30,-15},{-30,15}}), Line(points={{-10,-15},{-10,15}}),
      Rectangle(extent={{10,-40},{60,40}}, lineColor={0,0,0}, fillColor={86,180,233}, fillPattern=FillPattern.Solid),
      Line(points={{65,0},{90,0}}, arrow={Arrow.Filled,Arrow.Filled}),
      Text(extent={{-150,110},{150,150}}, textString="%name", textColor={0,0,255})}),
      Documentation(info="<html><p>Frame of a machine: support, stack, stage, motion.</p></html>"));
  end Rig;
  annotation(Documentation(info="<html><p>Shapes that classes of the library share.</p></html>"));
end Icons;

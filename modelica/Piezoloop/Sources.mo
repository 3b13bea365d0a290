within Piezoloop;
package Sources "Signals for the examples"
  extends Icons.Package;

  block Wave "Sum of raised cosines, held over each step as an FMU sees it"
    extends Icons.Block;
    parameter Real scale = 1 "Factor of the sum";
    parameter Real offset = 0 "Added to it";
    parameter Real amplitude[:] = {1} "Half the height of each wave";
    parameter Real frequency[size(amplitude, 1)](each unit="Hz") = {1} "Frequency of each wave";
    parameter Real step(unit="s", min = 0) = 1e-4 "Time for which a value is held";
    Interfaces.SignalOutput y "Signal" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    discrete Real held(start = 0, fixed = true) "Sum at the last sample";
  equation
    when sample(0, step) then
      held = Functions.raisedCosines(amplitude, frequency, time);
    end when;
    y = offset + scale*held;
    annotation(Icon(graphics={Line(points={{-80,-70},{-60,-40},{-40,40},{-20,70},{0,40},{20,-40},{40,-70},{60,-40},{80,40}}, color={0,0,127}, smooth=Smooth.Bezier)}),
      Documentation(info="<html><p><code>y = offset + scale*sum(amplitude[i]*(1 - cos(2*pi*frequency[i]*t)))</code>, held over each <code>step</code>.</p></html>"));
  end Wave;

  block Constant "Constant value"
    extends Icons.Block;
    parameter Real k = 0 "Value";
    Interfaces.SignalOutput y "Signal" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  equation
    y = k;
    annotation(Icon(graphics={Line(points={{-80,0},{80,0}}, color={0,0,127})}),
      Documentation(info="<html><p><code>y = k</code></p></html>"));
  end Constant;

  block Enable "True, but for a stretch of time"
    extends Icons.Block;
    parameter Real off(unit="s") = 8e-3 "Start of the stretch";
    parameter Real on(unit="s") = 12.1e-3 "End of the stretch";
    parameter Real step(unit="s", min = 0) = 1e-4 "Time between samples";
    output Boolean y "Signal" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    discrete Boolean held(start = true, fixed = true) "Value at the last sample";
  equation
    when sample(0, step) then
      held = time < off - 0.5*step or time > on - 0.5*step;
    end when;
    y = held;
    annotation(Icon(graphics={Line(points={{-80,60},{-20,60},{-20,-60},{30,-60},{30,60},{80,60}}, color={255,0,255})}),
      Documentation(info="<html><p>False from <code>off</code> until <code>on</code>, else true.</p></html>"));
  end Enable;
  annotation(Documentation(info="<html><p>Sources that need no other library. Those of the Modelica Standard Library can be connected in their place.</p></html>"));
end Sources;

within Piezoloop.Blocks;
package Creep "Slow part of the elongation"
  extends Icons.Package;
  block KelvinVoigtCreep "Creep as a sum of first-order elements with given time constants"
    extends Interfaces.PositionFilter;
    parameter Integer elements(min = 1, max = 64) "Number of elements";
    parameter Real share[elements](each unit="1") "Final creep of each element, relative to the step";
    parameter Real time_constant[elements](each unit="s", each min = 0) "Time constant of each element, increasing";
  protected
    Real z[elements](each start = 0, each fixed = true, each unit="um") "Elements";
  equation
    when initial() then
      reinit(z, fill(u_um, elements));
    end when;
    for i in 1:elements loop
      time_constant[i]*der(z[i]) = u_um - z[i];
    end for;
    y_um = u_um + share*z;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,62},{-29,68},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>kelvin-voigt-creep</code>. Creep as a sum of first-order elements with given time constants.</p><p><code>y = u + sum(share[i]*z[i]); time_constant[i]*z[i]' = u - z[i]</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>elements` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of elements</td></tr><tr><td>share</td><td>1</td><td>required</td><td></td><td></td><td>Final creep of each element, relative to the step</td></tr><tr><td>time_constant</td><td>s</td><td>required</td><td>0</td><td></td><td>Time constant of each element, increasing</td></tr></table><p>Source: H. Janocha, K. Kuhnen, Sensors and Actuators A 79 (2000) 83-89.</p><p>Compensated in front of the machine by inverse-kelvin-voigt-creep (closed form).</p><p>Effect: <code>creep</code>.</p><p>In the residual: below 1 Hz, follows the sign of the last step and is proportional to it, straight over the logarithm of time.</p><p>Looks like: <code>thermal_drift</code>, <code>self_heating</code>, <code>hysteresis</code>.</p><p>Distinguished by: repeat a staircase up and down with holds of 0.1 to 100 s: creep restarts at each step, drift does not.</p><p>In <code>p0-truth</code>: 0.570 % at most, 0.378 % rms.</p><p>In <code>p1-truth</code>: 0.404 % at most, 0.272 % rms.</p><p>In <code>p2-truth</code>: 0.113 % at most, 0.079 % rms.</p><p>In <code>p3-truth</code>: 0.066 % at most, 0.045 % rms.</p><p>In <code>p4-truth</code>: 0.372 % at most, 0.264 % rms.</p><p>In <code>evc-truth</code>: 0.394 % at most, 0.281 % rms.</p></html>"));
  end KelvinVoigtCreep;

  block LogarithmicCreep "Creep in proportion to the logarithm of time"
    extends Interfaces.PositionFilter;
    parameter Real shortest(unit="s", min = 1e-06, max = 1000) = 0.01 "Time after a step at which creep begins";
    parameter Real longest(unit="s", min = 0.001, max = 1000000000.0) = 10000 "Time after a step at which creep ends";
    parameter Real gain(unit="1") "Relative growth of the position per decade of time";
    parameter Real reference(unit="s", min = 0) = 0.1 "Time after a step at which the growth is defined as zero";
    parameter Integer elements(min = 1, max = 64) = 12 "Number of elements: 2*log10(longest/shortest), rounded";
  protected
    final parameter Real tau[elements](each unit="s") = {shortest*exp(Constants.euler)*10^((i - 0.5)/2) for i in 1:elements}
      "Time constants, two per decade";
    Real z[elements](each start = 0, each fixed = true, each unit="um") "Elements";
  equation
    when initial() then
      reinit(z, fill(u_um, elements));
    end when;
    for i in 1:elements loop
      tau[i]*der(z[i]) = u_um - z[i];
    end for;
    y_um = u_um*(1 - gain*log10(reference/shortest)) + gain/2*sum(z);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,69},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>logarithmic-creep</code>. Creep in proportion to the logarithm of time.</p><p><code>y(t) = y(reference)*(1 + gain*log10(t/reference)) after a step</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>shortest` (structure)</td><td>s</td><td>0.01</td><td>0.000001</td><td>1000</td><td>Time after a step at which creep begins</td></tr><tr><td>longest` (structure)</td><td>s</td><td>10000</td><td>0.001</td><td>1000000000</td><td>Time after a step at which creep ends</td></tr><tr><td>gain</td><td>1</td><td>required</td><td></td><td></td><td>Relative growth of the position per decade of time</td></tr><tr><td>reference</td><td>s</td><td>0.1</td><td>shortest</td><td>longest</td><td>Time after a step at which the growth is defined as zero</td></tr></table><p>Source: H. Jung, D.-G. Gweon, Rev. Sci. Instrum. 71 (2000) 1896-1900.</p><p>Effect: <code>creep</code>.</p><p>In the residual: below 1 Hz, follows the sign of the last step and is proportional to it, straight over the logarithm of time.</p><p>Looks like: <code>thermal_drift</code>, <code>self_heating</code>, <code>hysteresis</code>.</p><p>Distinguished by: repeat a staircase up and down with holds of 0.1 to 100 s: creep restarts at each step, drift does not.</p></html>"));
  end LogarithmicCreep;

  block FractionalCreep "Creep as a power law of frequency between two frequencies"
    extends Interfaces.PositionFilter;
    parameter Real lowest(unit="Hz", min = 1e-09, max = 1000000.0) = 0.0001 "Lower end of the band";
    parameter Real highest(unit="Hz", min = 1e-06, max = 1000000000.0) = 100 "Upper end of the band";
    parameter Real order(unit="1", min = 0, max = 0.9) "Order of the integral";
    parameter Integer elements(min = 1, max = 64) = 18 "Number of elements: 3*log10(highest/lowest), rounded";
  protected
    final parameter Real pole[elements](each unit="rad/s") =
      {2*Constants.pi*lowest*(highest/lowest)^((i - 0.5 - order/2)/elements) for i in 1:elements} "Poles";
    final parameter Real zero[elements](each unit="rad/s") =
      {2*Constants.pi*lowest*(highest/lowest)^((i - 0.5 + order/2)/elements) for i in 1:elements} "Zeros";
    final parameter Real share[elements](each unit="1") =
      Functions.residues(pole, zero) "Static gain of each element";
    Real z[elements](each start = 0, each fixed = true, each unit="um") "Elements";
  equation
    when initial() then
      reinit(z, fill(u_um, elements));
    end when;
    for i in 1:elements loop
      1/pole[i]*der(z[i]) = u_um - z[i];
    end for;
    y_um = u_um + share*z;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-73,33},{-52,46},{-23,55},{20,63},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>fractional-creep</code>. Creep as a power law of frequency between two frequencies.</p><p><code>G(s) = product((s + z[k])/(s + p[k])), about (s/(2*pi*highest))^(-order) between lowest and highest</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>lowest` (structure)</td><td>Hz</td><td>0.0001</td><td>0.000000001</td><td>1000000</td><td>Lower end of the band</td></tr><tr><td>highest` (structure)</td><td>Hz</td><td>100</td><td>0.000001</td><td>1000000000</td><td>Upper end of the band</td></tr><tr><td>order</td><td>1</td><td>required</td><td>0</td><td>0.9</td><td>Order of the integral</td></tr></table><p>Source: A. Oustaloup et al., IEEE Trans. Circuits and Systems I 47 (2000) 25-39.</p><p>Effect: <code>creep</code>.</p><p>In the residual: below 1 Hz, follows the sign of the last step and is proportional to it, straight over the logarithm of time.</p><p>Looks like: <code>thermal_drift</code>, <code>self_heating</code>, <code>hysteresis</code>.</p><p>Distinguished by: repeat a staircase up and down with holds of 0.1 to 100 s: creep restarts at each step, drift does not.</p></html>"));
  end FractionalCreep;
  annotation(Documentation(info="<html><p>Slow part of the elongation.</p></html>"));
end Creep;

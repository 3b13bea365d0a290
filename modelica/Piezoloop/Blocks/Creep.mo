within Piezoloop.Blocks;
package Creep "Slow part of the elongation"
  block KelvinVoigtCreep "Creep as a sum of first-order elements with given time constants"
    extends Interfaces.PositionFilter;
    parameter Integer elements(min = 1, max = 64) "Number of elements";
    parameter Real share[elements](each unit="1") "Part of a step that each element adds in the end";
    parameter Real time_constant[elements](each unit="s", each min = 0) "Time constant of each element, increasing";
  protected
    Real z[elements](each unit="um") "Elements";
  initial equation
    for i in 1:elements loop
      der(z[i]) = 0;
    end for;
  equation
    for i in 1:elements loop
      time_constant[i]*der(z[i]) = u_um - z[i];
    end for;
    y_um = u_um + share*z;
    annotation(Documentation(info="<html><p>Component <code>kelvin-voigt-creep</code>:</p><p><code>y = u + sum(share[i]*z[i]); time_constant[i]*z[i]' = u - z[i]</code></p></html>"));
  end KelvinVoigtCreep;

  block LogarithmicCreep "Creep that is straight over the logarithm of time"
    extends Interfaces.PositionFilter;
    parameter Real shortest(unit="s", min = 1e-06, max = 1000) = 0.01 "Time after a step at which creep begins";
    parameter Real longest(unit="s", min = 0.001, max = 1000000000.0) = 10000 "Time after a step at which creep ends";
    parameter Real gain(unit="1") "Growth of the position in a decade of time";
    parameter Real reference(unit="s", min = 0) = 0.1 "Time after a step at which the growth counts as zero";
    parameter Integer elements(min = 1, max = 64) = 12 "Number of elements: 2*log10(longest/shortest), rounded";
  protected
    final parameter Real tau[elements](each unit="s") = {shortest*exp(Constants.euler)*10^((i - 0.5)/2) for i in 1:elements}
      "Time constants, two per decade";
    Real z[elements](each unit="um") "Elements";
  initial equation
    for i in 1:elements loop
      der(z[i]) = 0;
    end for;
  equation
    for i in 1:elements loop
      tau[i]*der(z[i]) = u_um - z[i];
    end for;
    y_um = u_um*(1 - gain*log10(reference/shortest)) + gain/2*sum(z);
    annotation(Documentation(info="<html><p>Component <code>logarithmic-creep</code>:</p><p><code>y(t) = y(reference)*(1 + gain*log10(t/reference)) after a step</code></p></html>"));
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
    Real z[elements](each unit="um") "Elements";
  initial equation
    for i in 1:elements loop
      der(z[i]) = 0;
    end for;
  equation
    for i in 1:elements loop
      1/pole[i]*der(z[i]) = u_um - z[i];
    end for;
    y_um = u_um + share*z;
    annotation(Documentation(info="<html><p>Component <code>fractional-creep</code>:</p><p><code>G(s) = product((s + z[k])/(s + p[k])), about (s/(2*pi*highest))^(-order) between lowest and highest</code></p></html>"));
  end FractionalCreep;
end Creep;

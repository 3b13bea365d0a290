within Piezoloop.Blocks;
package Environment "Surroundings"
  extends Icons.Package;
  block ThermalDrift "Thermal growth of the structure: steady, settling, and in proportion to a given temperature"
    extends Interfaces.PositionFilter;
    parameter Real rate(unit="um/s") = 0 "Steady drift";
    parameter Real settling(unit="um") = 0 "Drift that settles after the start";
    parameter Real time_constant(unit="s", min = 0) = 1000 "Time constant";
    parameter Real expansion(unit="um/K") = 0 "Growth per kelvin";
    parameter Real temperature_change(unit="K") = 0 "Difference from the temperature at which the growth is zero";
  protected
    Real g(unit="um") "Growth by the temperature";
  initial equation
    der(g) = 0;
  equation
    time_constant*der(g) = expansion*temperature_change - g;
    y_um = u_um + rate*time + settling*(1 - exp(-time/time_constant)) + g;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-49,-19},{-13,19},{29,49},{80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>thermal-drift</code>. Thermal growth of the structure: steady, settling, and in proportion to a given temperature.</p><p><code>y = x + rate*t + settling*(1 - exp(-t/time_constant)) + g; time_constant*g' = expansion*temperature_change - g</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>rate</td><td>{position}/s</td><td>0</td><td></td><td></td><td>Steady drift</td></tr><tr><td>settling</td><td>{position}</td><td>0</td><td></td><td></td><td>Drift that settles after the start</td></tr><tr><td>time_constant</td><td>s</td><td>1000</td><td>0</td><td></td><td>Time constant</td></tr><tr><td>expansion</td><td>{position}/K</td><td>0</td><td></td><td></td><td>Growth per kelvin</td></tr><tr><td>temperature_change</td><td>K</td><td>0</td><td></td><td></td><td>Difference from the temperature at which the growth is zero</td></tr></table><p>Source: ISO 230-3, Determination of thermal effects.</p><p>Effect: <code>thermal_drift</code>.</p><p>In the residual: not coherent with the command; continues at zero command.</p><p>Looks like: <code>creep</code>, <code>self_heating</code>.</p><p>Distinguished by: record at zero command before and after.</p><p>In <code>p0-truth</code>: 0.030 % at most, 0.003 % rms.</p></html>"));
  end ThermalDrift;

  block ThermalExpansion "Thermal growth of the structure with the temperature of the surroundings"
    extends Interfaces.PositionFilter;
    parameter Real expansion(unit="um/K") "Growth per kelvin";
    parameter Real time_constant(unit="s", min = 0) = 1000 "Time constant of the structure";
    parameter Real reference(unit="degC", min = -273.15) = 20 "Temperature without growth";
    Interfaces.TemperatureInput temperature "Temperature of the surroundings" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
  protected
    Real temperature_C(unit="degC") = temperature - 273.15 "temperature in degC";
    Real T(unit="degC") "Temperature of the structure";
  initial equation
    if time_constant > 0 then
      der(T) = 0;
    end if;
  equation
    time_constant*der(T) = temperature_C - T;
    y_um = u_um + expansion*(T - reference);
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>thermal-expansion</code>. Thermal growth of the structure with the temperature of the surroundings.</p><p><code>y = x + expansion*(Ts - reference); time_constant*Ts' = temperature - Ts</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>expansion</td><td>{position}/K</td><td>required</td><td></td><td></td><td>Growth per kelvin</td></tr><tr><td>time_constant</td><td>s</td><td>1000</td><td>0</td><td></td><td>Time constant of the structure</td></tr><tr><td>reference</td><td>degC</td><td>20</td><td>-273.15</td><td></td><td>Temperature without growth</td></tr></table><p>Source: ISO 230-3, Determination of thermal effects.</p><p>Effect: <code>thermal_drift</code>.</p><p>In the residual: not coherent with the command; continues at zero command.</p><p>Looks like: <code>creep</code>, <code>self_heating</code>.</p><p>Distinguished by: record at zero command before and after.</p></html>"));
  end ThermalExpansion;

  block Disturbance "External disturbance of the position, for example played back from a log"
    extends Interfaces.PositionFilter;
    parameter Real gain(unit="1") = 1 "Factor of the disturbance";
    Interfaces.PositionInput disturbance "Disturbance from outside" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
  protected
    Real disturbance_um(unit="um") = disturbance/Constants.um "disturbance in um";
  equation
    y_um = u_um + gain*disturbance_um;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>disturbance</code>. External disturbance of the position, for example played back from a log.</p><p><code>y = x + gain*disturbance</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>gain</td><td>1</td><td>1</td><td></td><td></td><td>Factor of the disturbance</td></tr></table><p>Source: definition.</p></html>"));
  end Disturbance;

  block FloorVibration "Floor vibration: noise through a mode"
    extends Interfaces.PositionFilter;
    parameter Real rms(unit="um", min = 0) "Standard deviation";
    parameter Real frequency(unit="Hz", min = 0) = 10 "Frequency of the mode";
    parameter Real damping(unit="1", min = 0) = 0.1 "Damping ratio of the mode";
    Interfaces.NoiseInput n "Independent normal number of each step" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    final parameter Real w(unit="rad/s") = 2*Constants.pi*frequency "Natural angular frequency";
    final parameter Real strength(unit="um") = rms*sqrt(4*damping/(w*step)) "Strength of the noise that is held over each step";
    Real x(start = 0, fixed = true, unit="um") "Vibration";
    Real v(start = 0, fixed = true, unit="um") "Its rate over w";
  equation
    der(x) = w*v;
    der(v) = w*(strength*n - x - 2*damping*v);
    y_um = u_um + x;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,4},{-72,-18},{-63,38},{-55,-12},{-46,-45},{-38,27},{-30,60},{-21,-33},{-13,8},{-4,-52},{4,18},{12,50},{21,-22},{29,-8},{38,42},{46,-60},{54,15},{63,30},{71,-38},{80,0}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>floor-vibration</code>. Floor vibration: noise through a mode.</p><p><code>y = x + n; n'' + 2*damping*w*n' + w^2*n = w^2*white noise; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>rms</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Standard deviation</td></tr><tr><td>frequency</td><td>Hz</td><td>10</td><td>0</td><td></td><td>Frequency of the mode</td></tr><tr><td>damping</td><td>1</td><td>0.1</td><td>0</td><td></td><td>Damping ratio of the mode</td></tr><tr><td>seed</td><td>1</td><td>1</td><td></td><td></td><td>Seed of the noise</td></tr></table><p>Source: C. G. Gordon, Proc. SPIE 1619 (1992) 71-85 (levels).</p><p>Effect: <code>floor_vibration</code>.</p><p>In the residual: not coherent with the command, not repeatable over periods.</p><p>Looks like: <code>sensor_noise</code>, <code>periodic_disturbance</code>.</p><p>Distinguished by: coherence with an accelerometer.</p><p>In <code>p0-truth</code>: 0.030 % at most, 0.016 % rms.</p></html>"));
  end FloorVibration;
  annotation(Documentation(info="<html><p>Surroundings.</p></html>"));
end Environment;

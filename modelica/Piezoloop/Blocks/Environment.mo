within Piezoloop.Blocks;
package Environment "Surroundings"
  block ThermalDrift "Thermal growth of the structure: steady, settling, and by a given temperature"
    extends Interfaces.PositionFilter;
    parameter Real rate(unit="um/s") = 0 "Steady drift";
    parameter Real settling(unit="um") = 0 "Drift that settles after the start";
    parameter Real time_constant(unit="s", min = 0) = 1000 "Time constant";
    parameter Real expansion(unit="um/K") = 0 "Growth per kelvin";
    parameter Real temperature_change(unit="K") = 0 "Temperature less the one at which the growth is zero";
  protected
    Real g(unit="um") "Growth by the temperature";
  initial equation
    der(g) = 0;
  equation
    time_constant*der(g) = expansion*temperature_change - g;
    y_um = u_um + rate*time + settling*(1 - exp(-time/time_constant)) + g;
    annotation(Documentation(info="<html><p>Component <code>thermal-drift</code>:</p><p><code>y = x + rate*t + settling*(1 - exp(-t/time_constant)) + g; time_constant*g' = expansion*temperature_change - g</code></p></html>"));
  end ThermalDrift;

  block ThermalExpansion "Thermal growth of the structure by the temperature of the surroundings"
    extends Interfaces.PositionFilter;
    parameter Real expansion(unit="um/K") "Growth per kelvin";
    parameter Real time_constant(unit="s", min = 0) = 1000 "Time constant of the structure";
    parameter Real reference(unit="degC", min = -273.15) = 20 "Temperature without growth";
    Interfaces.TemperatureInput temperature "Temperature of the surroundings";
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
    annotation(Documentation(info="<html><p>Component <code>thermal-expansion</code>:</p><p><code>y = x + expansion*(Ts - reference); time_constant*Ts' = temperature - Ts</code></p></html>"));
  end ThermalExpansion;

  block Disturbance "Disturbance of the position from outside, as from a log that is played back"
    extends Interfaces.PositionFilter;
    parameter Real gain(unit="1") = 1 "Factor of the disturbance";
    Interfaces.PositionInput disturbance "Disturbance from outside";
  protected
    Real disturbance_um(unit="um") = disturbance/Constants.um "disturbance in um";
  equation
    y_um = u_um + gain*disturbance_um;
    annotation(Documentation(info="<html><p>Component <code>disturbance</code>:</p><p><code>y = x + gain*disturbance</code></p></html>"));
  end Disturbance;

  block FloorVibration "Floor vibration: noise through a mode"
    extends Interfaces.PositionFilter;
    parameter Real rms(unit="um", min = 0) "Standard deviation";
    parameter Real frequency(unit="Hz", min = 0) = 10 "Frequency of the mode";
    parameter Real damping(unit="1", min = 0) = 0.1 "Damping ratio of the mode";
    Interfaces.NoiseInput n "Independent normal number of each step";
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
    annotation(Documentation(info="<html><p>Component <code>floor-vibration</code>:</p><p><code>y = x + n; n'' + 2*damping*w*n' + w^2*n = w^2*white noise; w = 2*pi*frequency</code></p></html>"));
  end FloorVibration;
end Environment;

within Piezoloop;
package Rigs "Known machines"
  block Hold "Hands a position on once per step"
    extends Interfaces.PositionFilter;
    parameter Real step(unit="s", min = 0) = 20e-6 "Time between samples: the step of the blueprint";
  protected
    discrete Real held(start = 0, fixed = true, unit="um") "Position at the last sample";
  equation
    when sample(0, step) then
      held = u;
    end when;
    y = held;
  end Hold;

  block Evc "Elliptical vibration cutting device, axes Y and Z"
    Interfaces.CommandInput u[2] "Commands of axes Y and Z";
    Interfaces.PositionOutput y[2] "Positions of axes Y and Z";
    parameter Real step(unit="s", min = 0) = 2e-05 "Time between samples of the hysteresis";
    Electrical.AmplifierLag y_amplifier(bandwidth = 3000);
    Hysteresis.PrandtlIshlinskii y_hysteresis(plays = 10, r = {0, 6, 12, 18, 24, 30, 36, 42, 48, 54}, w = {0.01354, 0.0279, 0, 0.004014, 0.007765, 0, 0, 0, 0, 0}, step = step);
    Mechanics.Mode y_mechanics(frequency = 482.6, damping = 0.02);
    Sensors.SensorLag y_sensor(bandwidth = 10000);
    Hold y_hold(step = step);
    Electrical.AmplifierLag z_amplifier(bandwidth = 3000);
    Hysteresis.PrandtlIshlinskii z_hysteresis(plays = 10, r = {0, 6, 12, 18, 24, 30, 36, 42, 48, 54}, w = {0.02523, 0.04579, 0, 0.004541, 0.001636, 0, 0, 0, 0, 0}, step = step);
    Mechanics.Mode z_mechanics(frequency = 290.7, damping = 0.02);
    Sensors.SensorLag z_sensor(bandwidth = 10000);
    Hold z_hold(step = step);
  equation
    connect(u[1], y_amplifier.u);
    connect(y_amplifier.y, y_hysteresis.u);
    connect(y_hysteresis.y, y_mechanics.u);
    connect(y_mechanics.y, y_hold.u);
    connect(y_hold.y, y_sensor.u);
    connect(y_sensor.y, y[1]);
    connect(u[2], z_amplifier.u);
    connect(z_amplifier.y, z_hysteresis.u);
    connect(z_hysteresis.y, z_mechanics.u);
    connect(z_mechanics.y, z_hold.u);
    connect(z_hold.y, z_sensor.u);
    connect(z_sensor.y, y[2]);
    annotation(Documentation(info="<html><p>Rig <code>evc</code>, which hands signals on once per step as the FMU does. Hysteresis and hold each answer one step later than in the FMU, so y is the FMU's position two steps later.</p><p>Source: C. Zhang, Z. Shu, Y. Yuan, X. Gan, F. Yu, Compound Control of Trajectory Errors in a Non-Resonant Piezo-Actuated Elliptical Vibration Cutting Device, Tables 2 and 3, Figure 1; damping, amplifier and sensor bandwidth are assumed.</p></html>"));
  end Evc;
end Rigs;

within Piezoloop;
package Types "Quantities at the connectors: SI, with the units that people read as displayUnit"
  extends Icons.TypesPackage;
  type Command = Real(final unit="V", final quantity="ElectricPotential") "Voltage" annotation(Documentation(info="<html><p>Command of an axis, in V.</p></html>"));
  type Position = Real(final unit="m", final quantity="Length", displayUnit="um") "Position" annotation(Documentation(info="<html><p>Position of an axis, in m; tools show um.</p></html>"));
  type Velocity = Real(final unit="m/s", final quantity="Velocity", displayUnit="um/s") "Velocity" annotation(Documentation(info="<html><p>Velocity, in m/s.</p></html>"));
  type Force = Real(final unit="N", final quantity="Force") "Force" annotation(Documentation(info="<html><p>Force, in N.</p></html>"));
  type Current = Real(final unit="A", final quantity="ElectricCurrent") "Current" annotation(Documentation(info="<html><p>Current, in A.</p></html>"));
  type Charge = Real(final unit="C", final quantity="ElectricCharge", displayUnit="uC") "Charge" annotation(Documentation(info="<html><p>Electric charge, in C.</p></html>"));
  type Energy = Real(final unit="J", final quantity="Energy") "Energy" annotation(Documentation(info="<html><p>Energy, in J.</p></html>"));
  type Temperature = Real(final unit="K", final quantity="ThermodynamicTemperature", displayUnit="degC") "Temperature" annotation(Documentation(info="<html><p>Absolute temperature, in K; tools show degC.</p></html>"));
  annotation(Documentation(info="<html><p>Quantities at the connectors: SI, with the units that people read as displayUnit.</p></html>"));
end Types;

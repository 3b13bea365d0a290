within Piezoloop;
package Types "Quantities at the connectors, with the units of a blueprint"
  type Command = Real(unit="V", quantity="ElectricPotential");
  type Position = Real(unit="um", quantity="Length");
  type Force = Real(unit="N", quantity="Force");
  type Temperature = Real(unit="degC", quantity="ThermodynamicTemperature");
end Types;

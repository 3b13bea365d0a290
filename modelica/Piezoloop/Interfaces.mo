within Piezoloop;
package Interfaces "Connectors and what the blocks of a signal path share"
  connector CommandInput = input Types.Command;
  connector CommandOutput = output Types.Command;
  connector PositionInput = input Types.Position;
  connector PositionOutput = output Types.Position;
  connector ForceInput = input Types.Force;
  connector TemperatureInput = input Types.Temperature;
  connector NoiseInput = input Real(unit="1");
  connector SignalInput = input Real;
  connector SignalOutput = output Real;

  partial block CommandFilter "Command to command"
    CommandInput u "Command in front";
    CommandOutput y "Command behind";
  end CommandFilter;

  partial block Actuator "Command to position"
    CommandInput u "Command";
    PositionOutput y "Position";
  end Actuator;

  partial block PositionFilter "Position to position"
    PositionInput u "Position in front";
    PositionOutput y "Position behind";
  end PositionFilter;

  partial block Inverse "Position that is wanted to command"
    PositionInput u "Position that is wanted";
    CommandOutput y "Command";
  end Inverse;

  partial block ReferenceFilter "Reference to reference"
    PositionInput u "Reference";
    PositionOutput y "Reference with its lead";
  end ReferenceFilter;

  partial block PathFilter "Filter of a controller's path, of a reference or a command"
    SignalInput u "Signal in front";
    SignalOutput y "Signal behind";
  end PathFilter;

  partial block Controller "Feedforward to command"
    CommandInput u "Feedforward";
    CommandOutput y "Command";
  end Controller;
end Interfaces;

within Piezoloop;
package Blocks "Timing, actuator, creep, coupling and surroundings"
  extends Icons.Package;
  annotation(Documentation(info="<html><p>Blocks of a signal path that stand neither for the amplifier, the hysteresis, the mechanics nor the sensor.</p></html>"));
end Blocks;

within Piezoloop;
package Constants "Numbers, so that no other library is needed"
  extends Icons.Package;
  constant Real pi = 3.141592653589793 "Half the circumference over the radius";
  constant Real euler = 0.5772156649015329 "Euler's constant";
  constant Real um(unit="m/um") = 1e-6 "Metres per micrometre: parameters are in um as in a blueprint, connectors in m";
  annotation(Documentation(info="<html><p>Constants of the library.</p></html>"));
end Constants;

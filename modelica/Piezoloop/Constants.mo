within Piezoloop;
package Constants "Numbers, so that no other library is needed"
  constant Real pi = 3.141592653589793;
  constant Real euler = 0.5772156649015329 "Euler's constant";
end Constants;

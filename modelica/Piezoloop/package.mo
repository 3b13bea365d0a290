package Piezoloop "Piezo-actuated machines: the components of the tool Piezoloop"
  annotation(
    version = "0.1.0",
    Documentation(info = "<html>
<p>One block per component of <code>piezoloop list models</code>, with the same names, units, bounds and start values: a blueprint's
numbers can be copied. Commands are in V, positions in um. Blocks with memory run once per <code>step</code>, as the FMU does;
the others are differential equations.</p>
<p>A name that Modelica reserves gets an underscore at its end (<code>initial_</code>, <code>delay_</code>). The seed of a noise is not
a parameter here: its normal numbers are an input.</p>
</html>"));
end Piezoloop;

within Piezoloop;
package Examples "Models that can be simulated"
  extends Icons.ExamplesPackage;
  annotation(Documentation(info="<html><p>Each block alone, electromechanical chains with energy balances, and the rigs.</p></html>"));
end Examples;

within Piezoloop;
package Solve "The command at which a model's position is the wanted one, by bisection between two limits"
  extends Icons.Package;
  function prandtlIshlinskii "Command at which the model's position is the wanted one: Prandtl-Ishlinskii"
    extends Icons.Function;
    input Real wanted;
    input Real low;
    input Real high;
    input Real offset;
    input Real more "Added to every weight";
    input Real r[:];
    input Real w[size(r, 1)];
    input Real last[size(r, 1)];
    output Real command;
  protected
    Real a;
    Real b;
    Real m;
  algorithm
    a := low;
    b := high;
    for k in 1:60 loop
      m := 0.5*(a + b);
      if offset + Functions.envelopedSum(m, m, more, r, w, last) < wanted then
        a := m;
      else
        b := m;
      end if;
    end for;
    command := 0.5*(a + b);
    annotation(Documentation(info="<html><p>Command at which the model's position is the wanted one: Prandtl-Ishlinskii.</p></html>"));
  end prandtlIshlinskii;

  function envelopedPlays "The same for envelopes slope*u + shift"
    extends Icons.Function;
    input Real wanted;
    input Real low;
    input Real high;
    input Real offset;
    input Real a1;
    input Real left_shift;
    input Real b1;
    input Real right_shift;
    input Real r[:];
    input Real w[size(r, 1)];
    input Real last[size(r, 1)];
    output Real command;
  protected
    Real a;
    Real b;
    Real m;
  algorithm
    a := low;
    b := high;
    for k in 1:60 loop
      m := 0.5*(a + b);
      if offset + Functions.envelopedSum(a1*m + left_shift, b1*m + right_shift, 0, r, w, last) < wanted then
        a := m;
      else
        b := m;
      end if;
    end for;
    command := 0.5*(a + b);
    annotation(Documentation(info="<html><p>The same for envelopes slope*u + shift.</p></html>"));
  end envelopedPlays;

  function cubicPlays "The same for a cubic and plays with wider thresholds"
    extends Icons.Function;
    input Real wanted;
    input Real low;
    input Real high;
    input Real offset;
    input Real linear;
    input Real cubic;
    input Real r[:];
    input Real w[size(r, 1)];
    input Real wider;
    input Real last[size(r, 1)];
    output Real command;
  protected
    Real a;
    Real b;
    Real m;
  algorithm
    a := low;
    b := high;
    for k in 1:60 loop
      m := 0.5*(a + b);
      if offset + linear*m + cubic*m^3 + Functions.envelopedSum(m - wider, m + wider, 0, r, w, last) < wanted then
        a := m;
      else
        b := m;
      end if;
    end for;
    command := 0.5*(a + b);
    annotation(Documentation(info="<html><p>The same for a cubic and plays with wider thresholds.</p></html>"));
  end cubicPlays;

  function boucWen "The same for a Bouc-Wen model"
    extends Icons.Function;
    input Real wanted;
    input Real last;
    input Real h;
    input Real low;
    input Real high;
    input Real offset;
    input Real gain;
    input Real alpha;
    input Real beta;
    input Real gamma;
    input Real delta;
    input Real exponent;
    output Real command;
  protected
    Real a;
    Real b;
    Real m;
  algorithm
    a := low;
    b := high;
    for k in 1:60 loop
      m := 0.5*(a + b);
      if offset + gain*m - Functions.boucWen(h, m - last, alpha*gain, beta, gamma, delta, exponent) < wanted then
        a := m;
      else
        b := m;
      end if;
    end for;
    command := 0.5*(a + b);
    annotation(Documentation(info="<html><p>The same for a Bouc-Wen model.</p></html>"));
  end boucWen;

  function duhem "The same for a Duhem model"
    extends Icons.Function;
    input Real wanted;
    input Real last;
    input Real e;
    input Real low;
    input Real high;
    input Real offset;
    input Real slope;
    input Real half;
    input Real decay;
    output Real command;
  protected
    Real a;
    Real b;
    Real m;
  algorithm
    a := low;
    b := high;
    for k in 1:60 loop
      m := 0.5*(a + b);
      if offset + slope*m + Functions.duhem(e, m - last, half, decay) < wanted then
        a := m;
      else
        b := m;
      end if;
    end for;
    command := 0.5*(a + b);
    annotation(Documentation(info="<html><p>The same for a Duhem model.</p></html>"));
  end duhem;
  annotation(Documentation(info="<html><p>The command at which a model's position is the wanted one, by bisection between two limits.</p></html>"));
end Solve;

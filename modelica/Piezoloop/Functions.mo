within Piezoloop;
package Functions "What several blocks share; states go in and come out"
  extends Icons.Package;
  function shift "The past inputs after a step, newest first; all are u at the start"
    extends Icons.Function;
    input Real u;
    input Real on "1 after the first step, 0 in it";
    input Real last[:];
    output Real next[size(last, 1)];
  algorithm
    for i in 1:size(last, 1) loop
      next[i] := if i > 1 and on > 0 then last[max(i - 1, 1)] else u;
    end for;
    annotation(Documentation(info="<html><p>The past inputs after a step, newest first; all are u at the start.</p></html>"));
  end shift;

  function interpolate "Past input of so many steps ago, linear between samples"
    extends Icons.Function;
    input Real steps;
    input Real past[:];
    output Real y;
  algorithm
    y := 0;
    for i in 1:size(past, 1) loop
      y := y + max(0, 1 - abs(i - 1 - steps))*past[i];
    end for;
    annotation(Documentation(info="<html><p>Past input of so many steps ago, linear between samples.</p></html>"));
  end interpolate;

  function raisedCosines "Sum of waves that begin at zero with slope zero"
    extends Icons.Function;
    input Real amplitude[:];
    input Real frequency[size(amplitude, 1)];
    input Real t;
    output Real y;
  algorithm
    y := 0;
    for i in 1:size(amplitude, 1) loop
      y := y + amplitude[i]*(1 - cos(2*Constants.pi*frequency[i]*t));
    end for;
    annotation(Documentation(info="<html><p>Sum of waves that begin at zero with slope zero.</p></html>"));
  end raisedCosines;

  function curve "Straight lines between points, and on beyond the first and the last"
    extends Icons.Function;
    input Real u;
    input Real at[:];
    input Real value[size(at, 1)];
    output Real y;
  protected
    Real upper;
  algorithm
    y := value[1];
    for i in 1:size(at, 1) - 1 loop
      upper := if i < size(at, 1) - 1 then min(u, at[min(i + 1, size(at, 1))]) else u;
      y := y + (value[i + 1] - value[i])/(at[i + 1] - at[i])*((if i > 1 then max(upper, at[i]) else upper) - at[i]);
    end for;
    annotation(Documentation(info="<html><p>Straight lines between points, and on beyond the first and the last.</p></html>"));
  end curve;

  function play "One play: a piston in a cylinder of width 2r"
    extends Icons.Function;
    input Real u;
    input Real r;
    input Real last;
    output Real next;
  algorithm
    next := max(u - r, min(u + r, last));
    annotation(Documentation(info="<html><p>One play: a piston in a cylinder of width 2r.</p></html>"));
  end play;

  function plays "Plays with thresholds r + wider"
    extends Icons.Function;
    input Real u;
    input Real r[:];
    input Real wider;
    input Real last[size(r, 1)];
    output Real next[size(r, 1)];
  algorithm
    for i in 1:size(r, 1) loop
      next[i] := max(u - r[i] - wider, min(u + r[i] + wider, last[i]));
    end for;
    annotation(Documentation(info="<html><p>Plays with thresholds r + wider.</p></html>"));
  end plays;

  function envelopedPlays "Plays between a rising and a falling envelope"
    extends Icons.Function;
    input Real left;
    input Real right;
    input Real r[:];
    input Real last[size(r, 1)];
    output Real next[size(r, 1)];
  algorithm
    for i in 1:size(r, 1) loop
      next[i] := max(left - r[i], min(right + r[i], last[i]));
    end for;
    annotation(Documentation(info="<html><p>Plays between a rising and a falling envelope.</p></html>"));
  end envelopedPlays;

  function inverseThresholds "Thresholds of the inverse of a Prandtl-Ishlinskii model"
    extends Icons.Function;
    input Real r[:];
    input Real w[size(r, 1)];
    output Real y[size(r, 1)];
  algorithm
    for i in 1:size(r, 1) loop
      y[i] := inverseThreshold(r[i], r, w);
    end for;
    annotation(Documentation(info="<html><p>Thresholds of the inverse of a Prandtl-Ishlinskii model.</p></html>"));
  end inverseThresholds;

  function inverseThreshold "Threshold of the inverse that belongs to threshold ri"
    extends Icons.Function;
    input Real ri;
    input Real r[:];
    input Real w[size(r, 1)];
    output Real y;
  algorithm
    y := 0;
    for k in 1:size(r, 1) loop
      y := y + w[k]*max(ri - r[k], 0);
    end for;
    annotation(Documentation(info="<html><p>Threshold of the inverse that belongs to threshold ri.</p></html>"));
  end inverseThreshold;

  function inverseWeights "Weights of the inverse of a Prandtl-Ishlinskii model"
    extends Icons.Function;
    input Real r[:];
    input Real w[size(r, 1)];
    output Real y[size(r, 1)];
  algorithm
    for i in 1:size(r, 1) loop
      y[i] := inverseWeight(r[i], w[i], r, w);
    end for;
    annotation(Documentation(info="<html><p>Weights of the inverse of a Prandtl-Ishlinskii model.</p></html>"));
  end inverseWeights;

  function inverseWeight "Weight of the inverse that belongs to threshold ri and weight wi"
    extends Icons.Function;
    input Real ri;
    input Real wi;
    input Real r[:];
    input Real w[size(r, 1)];
    output Real y;
  protected
    Real before "Sum of the weights of smaller thresholds";
  algorithm
    before := 0;
    for k in 1:size(r, 1) loop
      before := before + (if r[k] < ri then w[k] else 0);
    end for;
    y := if before <= 0 then 1/wi else -wi/((before + wi)*before);
    annotation(Documentation(info="<html><p>Weight of the inverse that belongs to threshold ri and weight wi.</p></html>"));
  end inverseWeight;

  function deadZones "x + sum of one-sided dead zones"
    extends Icons.Function;
    input Real x;
    input Real edge[:];
    input Real slope[size(edge, 1)];
    output Real y;
  algorithm
    y := x;
    for j in 1:size(edge, 1) loop
      y := y + slope[j]*(if edge[j] > 0 then max(x - edge[j], 0) else min(x - edge[j], 0));
    end for;
    annotation(Documentation(info="<html><p>x + sum of one-sided dead zones.</p></html>"));
  end deadZones;

  function inverseEdges "Edges of the inverse map"
    extends Icons.Function;
    input Real edge[:];
    input Real slope[size(edge, 1)];
    output Real y[size(edge, 1)];
  algorithm
    for i in 1:size(edge, 1) loop
      y[i] := deadZones(edge[i], edge, slope);
    end for;
    annotation(Documentation(info="<html><p>Edges of the inverse map.</p></html>"));
  end inverseEdges;

  function inverseSlopes "Changes of slope of the inverse map"
    extends Icons.Function;
    input Real edge[:];
    input Real slope[size(edge, 1)];
    output Real y[size(edge, 1)];
  algorithm
    for i in 1:size(edge, 1) loop
      y[i] := inverseSlope(edge[i], slope[i], edge, slope);
    end for;
    annotation(Documentation(info="<html><p>Changes of slope of the inverse map.</p></html>"));
  end inverseSlopes;

  function inverseSlope "Change of slope of the inverse map at the image of edge ej"
    extends Icons.Function;
    input Real ej;
    input Real change;
    input Real edge[:];
    input Real slope[size(edge, 1)];
    output Real y;
  protected
    Real total "Slope of the map beyond the edge";
  algorithm
    total := 1;
    for k in 1:size(edge, 1) loop
      total := total + (if ej > 0 and edge[k] > 0 and edge[k] <= ej or ej < 0 and edge[k] < 0 and edge[k] >= ej then slope[k] else 0);
    end for;
    y := 1/total - 1/(total - change);
    annotation(Documentation(info="<html><p>Change of slope of the inverse map at the image of edge ej.</p></html>"));
  end inverseSlope;

  function relays "Relays of a Preisach model after a move to a level"
    extends Icons.Function;
    input Real level;
    input Real last[:];
    output Real next[size(last, 1)];
  protected
    Real row;
    Real column;
  algorithm
    for k in 1:size(last, 1) loop
      row := ceil((sqrt(8*k + 1) - 1)/2 - 1e-9);
      column := k - row*(row - 1)/2;
      next[k] := if level >= row then 1 else if level < column then 0 else last[k];
    end for;
    annotation(Documentation(info="<html><p>Relays of a Preisach model after a move to a level.</p></html>"));
  end relays;

  function relaySum "Output of a Preisach model after a move to a level"
    extends Icons.Function;
    input Real level;
    input Real mu[:];
    input Real last[size(mu, 1)];
    output Real y;
  protected
    Real row;
    Real column;
  algorithm
    y := 0;
    for k in 1:size(mu, 1) loop
      row := ceil((sqrt(8*k + 1) - 1)/2 - 1e-9);
      column := k - row*(row - 1)/2;
      y := y + mu[k]*(if level >= row then 1 else if level < column then 0 else last[k]);
    end for;
    annotation(Documentation(info="<html><p>Output of a Preisach model after a move to a level.</p></html>"));
  end relaySum;

  function nearestLevel "Level whose output comes nearest to the position that is wanted"
    extends Icons.Function;
    input Real wanted;
    input Real present;
    input Real levels;
    input Real mu[:];
    input Real last[size(mu, 1)];
    output Real level;
  protected
    Real above;
    Real below;
    Real best;
  algorithm
    above := 0;
    for k in 1:size(mu, 1) loop
      above := above + (if k <= levels and relaySum(k - 1, mu, last) < wanted then 1 else 0);
    end for;
    below := max(above - 1, 0);
    best := if abs(relaySum(below, mu, last) - wanted) < abs(relaySum(above, mu, last) - wanted) then below else above;
    level := if abs(relaySum(present, mu, last) - wanted) <= abs(relaySum(best, mu, last) - wanted) then present else best;
    annotation(Documentation(info="<html><p>Level whose output comes nearest to the position that is wanted.</p></html>"));
  end nearestLevel;

  function span "Way that counts where the rest decays"
    extends Icons.Function;
    input Real way;
    input Real decay;
    output Real y;
  algorithm
    y := if abs(decay*way) < 1e-8 then way*(1 - 0.5*decay*way) else (1 - exp(-decay*way))/decay;
    annotation(Documentation(info="<html><p>Way that counts where the rest decays.</p></html>"));
  end span;

  function relax "g after a way with dg = slope - decay*g"
    extends Icons.Function;
    input Real g;
    input Real way;
    input Real slope;
    input Real decay;
    output Real y;
  algorithm
    y := g + (slope - decay*g)*span(way, decay);
    annotation(Documentation(info="<html><p>g after a way with dg = slope - decay*g.</p></html>"));
  end relax;

  function boucWen "Hysteretic part after a change of the command"
    extends Icons.Function;
    input Real h;
    input Real change;
    input Real slope;
    input Real beta;
    input Real gamma;
    input Real delta;
    input Real exponent;
    output Real y;
  protected
    Real s "Direction";
    Real along "Decay while h has the sign of the direction";
    Real against "Decay while it has the other one";
    Real g;
    Real way;
    Real ratio;
    Real to_zero "Way until h is zero";
    Real count;
    Real top "Level that h cannot pass";
    Real bend;
    Real c;
    Real next;
  algorithm
    s := if change > 0 then 1 else -1;
    along := gamma + beta + delta*s;
    against := gamma - beta + delta*s;
    g := s*h;
    way := abs(change);
    if exponent <= 1 then
      ratio := against*g/slope;
      to_zero := if abs(against) < 1e-12 then -g/slope else -log(max(1 + ratio, 1e-300))/against;
      g := if g >= 0 then relax(g, way, slope, along)
        elseif ratio > -1 and to_zero < way then relax(0, way - to_zero, slope, along)
        else relax(g, way, slope, -against);
    else
      count := max(1, min(64, ceil(way*exponent*(beta + abs(gamma) + abs(delta))/0.02)));
      top := slope/(beta + gamma)*((beta + gamma)/along)^(1/exponent);
      for k in 1:64 loop
        if k <= count then
          c := if g >= 0 then along else against;
          bend := (abs(g)*(beta + gamma)/slope)^(exponent - 1);
          next := g + (slope - c*abs(g)*bend)*span(way/count, c*exponent*bend*(if g >= 0 then 1 else -1));
          g := if g <= top then min(next, top) else next;
        end if;
      end for;
    end if;
    y := s*g;
    annotation(Documentation(info="<html><p>Hysteretic part after a change of the command.</p></html>"));
  end boucWen;

  function duhem "Distance from the centre line after a change of the command"
    extends Icons.Function;
    input Real e;
    input Real change;
    input Real half "Distance of the major loop";
    input Real decay;
    output Real y;
  protected
    Real target;
  algorithm
    target := if change > 0 then -half else half;
    y := target + (e - target)*exp(-decay*abs(change));
    annotation(Documentation(info="<html><p>Distance from the centre line after a change of the command.</p></html>"));
  end duhem;

  function segmentWeight "Change of the weights by the segment of the loop"
    extends Icons.Function;
    input Real speed;
    input Real acceleration;
    input Real alpha[4];
    input Real beta[4];
    output Real y;
  algorithm
    y := if speed >= 0 then (if acceleration >= 0 then alpha[1]*speed + beta[1]*acceleration else alpha[2]*speed + beta[2]*acceleration)
      else (if acceleration <= 0 then alpha[3]*speed + beta[3]*acceleration else alpha[4]*speed + beta[4]*acceleration);
    annotation(Documentation(info="<html><p>Change of the weights by the segment of the loop.</p></html>"));
  end segmentWeight;

  function meanSlope "Mean slope of the largest loop"
    extends Icons.Function;
    input Real linear;
    input Real r[:];
    input Real w[size(r, 1)];
    input Real range;
    output Real y;
  algorithm
    y := linear;
    for i in 1:size(r, 1) loop
      y := y + w[i]*max(range - 2*r[i], 0)/range;
    end for;
    annotation(Documentation(info="<html><p>Mean slope of the largest loop.</p></html>"));
  end meanSlope;

  function envelopedSum "Output of enveloped plays after a move, without making it"
    extends Icons.Function;
    input Real left;
    input Real right;
    input Real more "Added to every weight";
    input Real r[:];
    input Real w[size(r, 1)];
    input Real last[size(r, 1)];
    output Real y;
  algorithm
    y := 0;
    for i in 1:size(r, 1) loop
      y := y + (w[i] + more)*max(left - r[i], min(right + r[i], last[i]));
    end for;
    annotation(Documentation(info="<html><p>Output of enveloped plays after a move, without making it.</p></html>"));
  end envelopedSum;

  function residues "Static gain of each element of product((s + zero)/(s + pole)), taken apart"
    extends Icons.Function;
    input Real pole[:];
    input Real zero[size(pole, 1)];
    output Real y[size(pole, 1)];
  algorithm
    for i in 1:size(pole, 1) loop
      y[i] := residue(pole[i], zero[i], pole, zero);
    end for;
    annotation(Documentation(info="<html><p>Static gain of each element of product((s + zero)/(s + pole)), taken apart.</p></html>"));
  end residues;

  function residue "Static gain of the element with pole p, whose zero is z"
    extends Icons.Function;
    input Real p;
    input Real z;
    input Real pole[:];
    input Real zero[size(pole, 1)];
    output Real y;
  algorithm
    y := (z - p)/p;
    for j in 1:size(pole, 1) loop
      y := y*(if abs(pole[j] - p) <= 1e-12*p then 1 else (zero[j] - p)/(if abs(pole[j] - p) <= 1e-12*p then 1 else pole[j] - p));
    end for;
    annotation(Documentation(info="<html><p>Static gain of the element with pole p, whose zero is z.</p></html>"));
  end residue;

  function rowProduct "Row i of a matrix that is given row by row, times a vector"
    extends Icons.Function;
    input Real matrix[:];
    input Integer i;
    input Real x[:];
    output Real y;
  algorithm
    y := 0;
    for j in 1:size(x, 1) loop
      y := y + matrix[(i - 1)*size(x, 1) + j]*x[j];
    end for;
    annotation(Documentation(info="<html><p>Row i of a matrix that is given row by row, times a vector.</p></html>"));
  end rowProduct;

  function flicker "Lags of 1/f noise after a step"
    extends Icons.Function;
    input Real pole[:];
    input Real weight[size(pole, 1)];
    input Real beyond "What the poles below the first one add to it";
    input Real step;
    input Real drive;
    input Real last[size(pole, 1)];
    output Real next[size(pole, 1)];
  algorithm
    for i in 1:size(pole, 1) loop
      next[i] := exp(-pole[i]*step)*last[i] + (1 - exp(-pole[i]*step))*weight[i]*(if i == 1 then 1 + beyond else 1)*drive;
    end for;
    annotation(Documentation(info="<html><p>Lags of 1/f noise after a step.</p></html>"));
  end flicker;

  function excess "How far beyond a limit, with a parabola within softness of it"
    extends Icons.Function;
    input Real d;
    input Real softness;
    output Real y;
  algorithm
    y := if d >= softness then d elseif d <= -softness then 0 else (d + softness)^2/(4*softness);
    annotation(Documentation(info="<html><p>How far beyond a limit, with a parabola within softness of it.</p></html>"));
  end excess;

  function round "To the nearest whole number, halves away from zero"
    extends Icons.Function;
    input Real x;
    output Real y;
  algorithm
    y := if x >= 0 then floor(x + 0.5) else -floor(0.5 - x);
    annotation(Documentation(info="<html><p>To the nearest whole number, halves away from zero.</p></html>"));
  end round;

  function atanh "Inverse of tanh within 1e-9 of its ends"
    extends Icons.Function;
    input Real x;
    output Real y;
  protected
    Real inside;
  algorithm
    inside := max(1e-9 - 1, min(1 - 1e-9, x));
    y := 0.5*log((1 + inside)/(1 - inside));
    annotation(Documentation(info="<html><p>Inverse of tanh within 1e-9 of its ends.</p></html>"));
  end atanh;

  function erf "Error function: its series without cancellation, 1 beyond 6"
    extends Icons.Function;
    input Real x;
    output Real y;
  protected
    Real limited;
    Real term;
    Real total;
  algorithm
    limited := max(-6, min(6, x));
    term := limited;
    total := limited;
    for n in 1:200 loop
      term := term*2*limited^2/(2*n + 1);
      total := total + term;
    end for;
    y := 2/sqrt(3.141592653589793)*exp(-limited^2)*total;
    annotation(Documentation(info="<html><p>Error function: its series without cancellation, 1 beyond 6.</p></html>"));
  end erf;

  function enter "A value in front of the past ones (way 1), in all places (way -1), or none (way 0)"
    extends Icons.Function;
    input Real u;
    input Real way;
    input Real last[:];
    output Real next[size(last, 1)];
  algorithm
    for i in 1:size(last, 1) loop
      next[i] := if way < -0.5 or way > 0.5 and i < 2 then u elseif way > 0.5 then last[max(i - 1, 1)] else last[i];
    end for;
    annotation(Documentation(info="<html><p>A value in front of the past ones (way 1), in all places (way -1), or none (way 0).</p></html>"));
  end enter;

  function lags "Lags after a step; all are u before the first one"
    extends Icons.Function;
    input Real u;
    input Real on "1 after the first step, 0 in it";
    input Real fraction[:];
    input Real last[size(fraction, 1)];
    output Real next[size(fraction, 1)];
  algorithm
    for i in 1:size(fraction, 1) loop
      next[i] := if on > 0 then last[i] + fraction[i]*(u - last[i]) else u;
    end for;
    annotation(Documentation(info="<html><p>Lags after a step; all are u before the first one.</p></html>"));
  end lags;

  function window "Past values about half places before the last, under a Hann window"
    extends Icons.Function;
    input Integer half;
    input Real last[:];
    output Real y;
  protected
    Real tap;
    Real total;
  algorithm
    y := 0;
    total := 0;
    for i in 1:size(last, 1) loop
      tap := if i < size(last, 1) - 2*half then 0
        else 0.5*(1 + cos(3.141592653589793*(i + half - size(last, 1))/(half + 1)));
      total := total + tap;
      y := y + tap*last[i];
    end for;
    y := y/total;
    annotation(Documentation(info="<html><p>Past values about half places before the last, under a Hann window.</p></html>"));
  end window;

  function limited "Within the limits and at most so far from the last one, 0 for any"
    extends Icons.Function;
    input Real free;
    input Real last;
    input Real low;
    input Real high;
    input Real most;
    output Real y;
  protected
    Real wanted;
  algorithm
    wanted := max(low, min(high, free));
    y := if most > 0 then max(low, min(high, max(last - most, min(last + most, wanted)))) else wanted;
    annotation(Documentation(info="<html><p>Within the limits and at most so far from the last one, 0 for any.</p></html>"));
  end limited;

  function transitionEven "Second order over an angle: mean of the exponentials"
    extends Icons.Function;
    input Real angle;
    input Real damping;
    output Real y;
  protected
    Real root;
  algorithm
    root := sqrt(abs((1 - damping)*(1 + damping)));
    y := if damping < 1 then exp(-damping*angle)*cos(root*angle)
      else 0.5*(exp(-angle/(damping + root)) + exp(-angle*(damping + root)));
    annotation(Documentation(info="<html><p>Second order over an angle: mean of the exponentials.</p></html>"));
  end transitionEven;

  function transitionOdd "Second order over an angle: half difference of the exponentials over its root"
    extends Icons.Function;
    input Real angle;
    input Real damping;
    output Real y;
  protected
    Real root;
  algorithm
    root := sqrt(abs((1 - damping)*(1 + damping)));
    y := if root < 1e-9 then angle*exp(-angle)
      elseif damping < 1 then exp(-damping*angle)*sin(root*angle)/root
      elseif root*angle < 1 then exp(-damping*angle)*sinh(root*angle)/root
      else (exp(-angle/(damping + root)) - exp(-angle*(damping + root)))/(2*root);
    annotation(Documentation(info="<html><p>Second order over an angle: half difference of the exponentials over its root.</p></html>"));
  end transitionOdd;

  function rowDifference "Row i of a matrix that is given row by row, times a difference"
    extends Icons.Function;
    input Real matrix[:];
    input Integer i;
    input Real x[:];
    input Real x0[size(x, 1)];
    output Real y;
  algorithm
    y := 0;
    for j in 1:size(x, 1) loop
      y := y + matrix[(i - 1)*size(x, 1) + j]*(x[j] - x0[j]);
    end for;
    annotation(Documentation(info="<html><p>Row i of a matrix that is given row by row, times a difference.</p></html>"));
  end rowDifference;

  function inverseMatrix "Inverse of a matrix that is given row by row"
    extends Icons.Function;
    input Real matrix[:];
    input Real like[:] "Any vector with as many entries as it has rows";
    output Real y[size(matrix, 1)];
  protected
    Real a[size(matrix, 1)] "What is left of the matrix";
    Real pivot;
    Real factor;
    Real moved;
    Integer at;
  algorithm
    for k in 1:size(matrix, 1) loop
      a[k] := matrix[k];
      y[k] := if mod(k - 1, size(like, 1) + 1) == 0 then 1 else 0;
    end for;
    for k in 1:size(like, 1) loop
      at := k;
      for row in 1:size(like, 1) loop
        at := if row > k and abs(a[(row - 1)*size(like, 1) + k]) > abs(a[(at - 1)*size(like, 1) + k]) then row else at;
      end for;
      at := if abs(a[(k - 1)*size(like, 1) + k]) >= 0.1*abs(a[(at - 1)*size(like, 1) + k]) then k else at;
      pivot := a[(at - 1)*size(like, 1) + k];
      for j in 1:size(like, 1) loop
        moved := a[(at - 1)*size(like, 1) + j]/pivot;
        a[(at - 1)*size(like, 1) + j] := a[(k - 1)*size(like, 1) + j];
        a[(k - 1)*size(like, 1) + j] := moved;
        moved := y[(at - 1)*size(like, 1) + j]/pivot;
        y[(at - 1)*size(like, 1) + j] := y[(k - 1)*size(like, 1) + j];
        y[(k - 1)*size(like, 1) + j] := moved;
      end for;
      for row in 1:size(like, 1) loop
        factor := if row == k then 0 else a[(row - 1)*size(like, 1) + k];
        for j in 1:size(like, 1) loop
          a[(row - 1)*size(like, 1) + j] := a[(row - 1)*size(like, 1) + j] - factor*a[(k - 1)*size(like, 1) + j];
          y[(row - 1)*size(like, 1) + j] := y[(row - 1)*size(like, 1) + j] - factor*y[(k - 1)*size(like, 1) + j];
        end for;
      end for;
    end for;
    annotation(Documentation(info="<html><p>Inverse of a matrix that is given row by row.</p></html>"));
  end inverseMatrix;
  annotation(Documentation(info="<html><p>What several blocks share; states go in and come out.</p></html>"));
end Functions;

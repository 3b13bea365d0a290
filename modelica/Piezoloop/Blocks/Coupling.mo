within Piezoloop.Blocks;
package Coupling "Several axes at once"
  extends Icons.Package;
  block CommandCoupling "Static coupling from the neighbours' commands"
    extends Icons.Block;
    parameter Integer axes(min = 2, max = 4) "Number of coupled axes";
    parameter Integer entries(min = 4, max = 16) "Number of entries of the matrix";
    parameter Real matrix[entries](each unit="um/V") "Motion per command of the neighbour, row by row, zero on the diagonal";
    Interfaces.PositionInput u[axes] "Position of each axis in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[axes] "Position of each axis behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    Interfaces.CommandInput command[axes] "Command of each axis" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
  equation
    y = Constants.um*y_um;
    for i in 1:axes loop
      y_um[i] = u_um[i] + Functions.rowProduct(matrix, i, command);
    end for;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{80,70},{-80,-70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>command-coupling</code>. Static coupling from the neighbours' commands.</p><p><code>y[i] = x[i] + sum(matrix[i,j]*u[j])</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>axes` (structure)</td><td>1</td><td>by its lists</td><td>2</td><td>4</td><td>Number of coupled axes</td></tr><tr><td>entries` (structure)</td><td>1</td><td>by its lists</td><td>4</td><td>16</td><td>Number of entries of the matrix</td></tr><tr><td>matrix</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Motion per command of the neighbour, row by row, zero on the diagonal</td></tr></table><p>Source: S. Devasia, E. Eleftheriou, S. O. R. Moheimani, IEEE Trans. CST 15 (2007) 802-823.</p><p>Effect: <code>cross_coupling</code>.</p><p>In the residual: coherent with the other axis' input; where dynamic, at the other axis' resonance.</p><p>Looks like: <code>floor_vibration</code>, <code>crosstalk</code>.</p><p>Distinguished by: drive one axis at a time; orthogonal multisines.</p></html>"));
  end CommandCoupling;

  block DisplacementCoupling "Coupling from the neighbours' motion, with their dynamics"
    extends Icons.Block;
    parameter Integer axes(min = 2, max = 8) "Number of coupled axes";
    parameter Integer entries(min = 4, max = 64) "Number of entries of the matrix";
    parameter Real matrix[entries](each unit="1") "Motion per motion of the neighbour, row by row, zero on the diagonal";
    Interfaces.PositionInput u[axes] "Position of each axis in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[axes] "Position of each axis behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
  equation
    y = Constants.um*y_um;
    for i in 1:axes loop
      y_um[i] = u_um[i] + Functions.rowProduct(matrix, i, u_um);
    end for;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,70},{80,-70},{-80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>displacement-coupling</code>. Coupling from the neighbours' motion, with their dynamics.</p><p><code>y[i] = x[i] + sum(matrix[i,j]*x[j])</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>axes` (structure)</td><td>1</td><td>by its lists</td><td>2</td><td>8</td><td>Number of coupled axes</td></tr><tr><td>entries` (structure)</td><td>1</td><td>by its lists</td><td>4</td><td>64</td><td>Number of entries of the matrix</td></tr><tr><td>matrix</td><td>1</td><td>required</td><td></td><td></td><td>Motion per motion of the neighbour, row by row, zero on the diagonal</td></tr></table><p>Source: S. Devasia, E. Eleftheriou, S. O. R. Moheimani, IEEE Trans. CST 15 (2007) 802-823.</p><p>Effect: <code>cross_coupling</code>.</p><p>In the residual: coherent with the other axis' input; where dynamic, at the other axis' resonance.</p><p>Looks like: <code>floor_vibration</code>, <code>crosstalk</code>.</p><p>Distinguished by: drive one axis at a time; orthogonal multisines.</p><p>In <code>p0-truth</code>: 0.420 % at most, 0.232 % rms.</p></html>"));
  end DisplacementCoupling;

  block ModeCoupling "Coupling from the neighbours' commands through a mode of each neighbour"
    extends Icons.Block;
    parameter Integer axes(min = 2, max = 4) "Number of coupled axes";
    parameter Integer entries(min = 4, max = 16) "Number of entries of the matrix";
    parameter Real matrix[entries](each unit="um/V") "Motion per command of the neighbour, row by row, zero on the diagonal";
    parameter Real frequency[axes](each unit="Hz", each min = 0) "Undamped natural frequency of each axis' mode";
    parameter Real damping[axes](each unit="1", each min = 0) "Damping ratio of each axis' mode";
    Interfaces.PositionInput u[axes] "Position of each axis in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[axes] "Position of each axis behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
    Interfaces.CommandInput command[axes] "Command of each axis" annotation(Placement(transformation(extent={{-80,-120},{-40,-80}})));
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
    Real z[axes](each unit="V") "Mode of each axis";
    Real v[axes](each unit="V") "Its rate over its angular frequency";
  initial equation
    for i in 1:axes loop
      der(z[i]) = 0;
      der(v[i]) = 0;
    end for;
  equation
    y = Constants.um*y_um;
    for i in 1:axes loop
      der(z[i]) = 2*Constants.pi*frequency[i]*v[i];
      der(v[i]) = 2*Constants.pi*frequency[i]*(command[i] - z[i] - 2*damping[i]*v[i]);
      y_um[i] = u_um[i] + Functions.rowProduct(matrix, i, z);
    end for;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-72,-65},{-65,46},{-61,70},{-49,-49},{-37,53},{-27,-25},{-24,-35},{-13,40},{0,-24},{11,30},{14,26},{24,-16},{27,-12},{36,24},{48,-10},{51,-8},{60,19},{63,16},{72,-6},{76,-3},{80,8}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>mode-coupling</code>. Coupling from the neighbours' commands through a mode of each neighbour.</p><p><code>y[i] = x[i] + sum(matrix[i,j]*z[j]); z'' + 2*damping*w*z' + w^2*z = w^2*u; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>axes` (structure)</td><td>1</td><td>by its lists</td><td>2</td><td>4</td><td>Number of coupled axes</td></tr><tr><td>entries` (structure)</td><td>1</td><td>by its lists</td><td>4</td><td>16</td><td>Number of entries of the matrix</td></tr><tr><td>matrix</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Motion per command of the neighbour, row by row, zero on the diagonal</td></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Undamped natural frequency of each axis' mode</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio of each axis' mode</td></tr></table><p>Source: S. Devasia, E. Eleftheriou, S. O. R. Moheimani, IEEE Trans. CST 15 (2007) 802-823.</p><p>Effect: <code>cross_coupling</code>.</p><p>In the residual: coherent with the other axis' input; where dynamic, at the other axis' resonance.</p><p>Looks like: <code>floor_vibration</code>, <code>crosstalk</code>.</p><p>Distinguished by: drive one axis at a time; orthogonal multisines.</p></html>"));
  end ModeCoupling;

  block ModalMatrix "Linear structure with several inputs and outputs: modes that all axes share"
    extends Icons.Block;
    parameter Integer axes(min = 1, max = 8) "Number of coupled axes";
    parameter Integer entries(min = 1, max = 64) "Number of entries of a matrix";
    parameter Integer modes(min = 1, max = 64) "Number of modes";
    parameter Integer residues(min = 1, max = 4096) "Entries of all modes' matrices";
    parameter Real direct[entries](each unit="1") "Motion per motion outside the listed modes, row by row";
    parameter Real frequency[modes](each unit="Hz", each min = 0) "Undamped natural frequency of each mode";
    parameter Real damping[modes](each unit="1", each min = 0) "Damping ratio of each mode";
    parameter Real residue[residues](each unit="1") "Static motion per motion through each mode, row by row, mode after mode";
    parameter Real rate_residue[residues](each unit="1") "Motion per rate of each mode over its angular frequency, row by row, mode after mode";
    Interfaces.PositionInput u[axes] "Position of each axis in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[axes] "Position of each axis behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
    Real z[modes,axes](each unit="um") "Each mode under each axis";
    Real v[modes,axes](each unit="um") "Its rate over its angular frequency";
    Real s[modes + 1,axes](each unit="um") "Direct motion and the modes up to each";
  initial equation
    for k in 1:modes loop
      for j in 1:axes loop
        der(z[k,j]) = 0;
        der(v[k,j]) = 0;
      end for;
    end for;
  equation
    y = Constants.um*y_um;
    for k in 1:modes loop
      for j in 1:axes loop
        der(z[k,j]) = 2*Constants.pi*frequency[k]*v[k,j];
        der(v[k,j]) = 2*Constants.pi*frequency[k]*(u_um[j] - z[k,j] - 2*damping[k]*v[k,j]);
      end for;
    end for;
    for i in 1:axes loop
      s[1,i] = Functions.rowProduct(direct, i, u_um);
      for k in 1:modes loop
        s[k + 1,i] = s[k,i] + Functions.rowProduct(residue, (k - 1)*axes + i, z[k,:])
          + Functions.rowProduct(rate_residue, (k - 1)*axes + i, v[k,:]);
      end for;
      y_um[i] = s[modes + 1,i];
    end for;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-65,47},{-61,67},{-49,-9},{-37,70},{-25,9},{-22,15},{-13,64},{0,18},{11,57},{14,54},{24,24},{35,53},{38,51},{48,28},{51,30},{60,49},{63,47},{72,31},{75,32},{80,41}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>modal-matrix</code>. Linear structure with several inputs and outputs: modes that all axes share.</p><p><code>y[i] = sum(direct[i,j]*x[j]) + sum(residue[k,i,j]*z[k,j] + rate_residue[k,i,j]*z[k,j]'/w[k]); z'' + 2*damping*w*z' + w^2*z = w^2*x; w = 2*pi*frequency</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>axes` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>8</td><td>Number of coupled axes</td></tr><tr><td>entries` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of entries of a matrix</td></tr><tr><td>modes` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of modes</td></tr><tr><td>residues` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Entries of all modes' matrices</td></tr><tr><td>direct</td><td>1</td><td>required</td><td></td><td></td><td>Motion per motion outside the listed modes, row by row</td></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Undamped natural frequency of each mode</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio of each mode</td></tr><tr><td>residue</td><td>1</td><td>required</td><td></td><td></td><td>Static motion per motion through each mode, row by row, mode after mode</td></tr><tr><td>rate_residue</td><td>1</td><td>required</td><td></td><td></td><td>Motion per rate of each mode over its angular frequency, row by row, mode after mode</td></tr></table><p>Source: J.-N. Juang, R. S. Pappa, J. Guidance 8 (1985) 620-627.</p></html>"));
  end ModalMatrix;

  block OpticsJacobian "From the angles of several mirrors to the coordinates of the spots on the sensors"
    extends Icons.Block;
    parameter Integer axes(min = 2, max = 32) "Number of coupled axes";
    parameter Integer entries(min = 4, max = 1024) "Number of entries of the matrix";
    parameter Real matrix[entries](each unit="um/V") "Jacobian, row by row";
    parameter Real offset[axes](each unit="um") "Coordinates at zero angles";
    Interfaces.PositionInput u[axes] "Position of each axis in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[axes] "Position of each axis behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
  equation
    y = Constants.um*y_um;
    for i in 1:axes loop
      y_um[i] = offset[i] + Functions.rowProduct(matrix, i, u_um);
    end for;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,70},{80,-70},{-80,70}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>optics-jacobian</code>. From the angles of several mirrors to the coordinates of the spots on the sensors.</p><p><code>p[i] = offset[i] + sum(matrix[i,j]*theta[j])</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>axes` (structure)</td><td>1</td><td>by its lists</td><td>2</td><td>32</td><td>Number of coupled axes</td></tr><tr><td>entries` (structure)</td><td>1</td><td>by its lists</td><td>4</td><td>1024</td><td>Number of entries of the matrix</td></tr><tr><td>matrix</td><td>{position}/{command}</td><td>required</td><td></td><td></td><td>Jacobian, row by row</td></tr><tr><td>offset</td><td>{position}</td><td>required</td><td></td><td></td><td>Coordinates at zero angles</td></tr></table><p>Source: laser beam steering with dual-axis mirrors and position-sensitive detectors: p = J*theta + p0.</p></html>"));
  end OpticsJacobian;

  block PsdPincushion "Pincushion distortion of a position-sensitive detector"
    extends Icons.Block;
    parameter Integer axes(min = 2, max = 2) "Number of axes, 2";
    parameter Real distortion(unit="1") "Relative shift at half_size on an axis";
    parameter Real half_size(unit="um", min = 0) "Half the edge of the detector";
    Interfaces.PositionInput u[axes] "Position of each axis in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[axes] "Position of each axis behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
  equation
    y = Constants.um*y_um;
    for i in 1:axes loop
      y_um[i] = u_um[i]*(1 + distortion*(u_um[1]^2 + u_um[2]^2)/half_size^2);
    end for;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Polygon(points={{-70,-70},{0,-55},{70,-70},{55,0},{70,70},{0,55},{-70,70},{-55,0},{-70,-70}}, lineColor={0,0,127}, smooth=Smooth.Bezier)}),
      Documentation(info="<html><p>Component <code>psd-pincushion</code>. Pincushion distortion of a position-sensitive detector.</p><p><code>q[i] = p[i]*(1 + distortion*(p[1]^2 + p[2]^2)/half_size^2)</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>axes` (structure)</td><td>1</td><td>by its lists</td><td>2</td><td>2</td><td>Number of axes, 2</td></tr><tr><td>distortion</td><td>1</td><td>required</td><td></td><td></td><td>Relative shift at half_size on an axis</td></tr><tr><td>half_size</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Half the edge of the detector</td></tr></table><p>Source: W. Wang, I. J. Busch-Vishniac, Applied Optics 28 (1989) 4504.</p><p>Effect: <code>sensor_nonlinearity</code>.</p><p>In the residual: a polynomial of the position, the same on both branches and at every rate.</p><p>Looks like: <code>asymmetry</code>, <code>polarisation_saturation</code>, <code>amplifier_saturation</code>.</p><p>Distinguished by: interferometer as reference; shift the working range.</p><p>In <code>p0-truth</code>: 0.030 % at most, 0.005 % rms.</p></html>"));
  end PsdPincushion;

  block SofteningModes "Modes that all axes share, with frequency and damping that follow the amplitude"
    extends Icons.Block;
    parameter Integer axes(min = 1, max = 8) "Number of coupled axes";
    parameter Integer entries(min = 1, max = 64) "Number of entries of a matrix";
    parameter Integer modes(min = 1, max = 64) "Number of modes";
    parameter Integer residues(min = 1, max = 4096) "Entries of all modes' matrices";
    parameter Real direct[entries](each unit="1") "Motion per motion outside the listed modes, row by row";
    parameter Real frequency[modes](each unit="Hz", each min = 0) "Undamped natural frequency of each mode, small motion";
    parameter Real damping[modes](each unit="1", each min = 0) "Damping ratio of each mode, small motion";
    parameter Real frequency_shift[modes](each unit="1") "Relative change of each mode's frequency at `amplitude`, negative where it softens";
    parameter Real damping_growth[modes](each unit="1") "Relative change of each mode's damping ratio at `amplitude`";
    parameter Real residue[residues](each unit="1") "Static motion per motion through each mode, row by row, mode after mode";
    parameter Real rate_residue[residues](each unit="1") "Motion per rate of each mode over its angular frequency, row by row, mode after mode";
    parameter Real amplitude[axes](each unit="um", each min = 0) "Rms of each axis' motion before the coupling at which shift and growth are given";
    parameter Real exponent(unit="1", min = 0) = 1.0 "Exponent of the amplitude in shift and growth";
    parameter Real time_constant(unit="s", min = 0) = 0.1 "Time constant of the running rms";
    Interfaces.PositionInput u[axes] "Position of each axis in front" annotation(Placement(transformation(extent={{-120,-20},{-80,20}})));
    Interfaces.PositionOutput y[axes] "Position of each axis behind" annotation(Placement(transformation(extent={{100,-10},{120,10}})));
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
    Real z[modes,axes](each unit="um") "Each mode under each axis";
    Real v[modes,axes](each unit="um") "Its rate over its angular frequency";
    Real total[modes + 1,axes](each unit="um") "Direct motion and the modes up to each";
    Real mean[axes](each unit="um") "Running mean of each axis in front";
    Real power(unit="1", start = 0, fixed = true) "Running mean square about it, over that of the amplitude";
    Real way[axes](each unit="1") "Distance from the mean over the amplitude";
    Real s(unit="1") "What shift and growth are multiplied by";
    Real w[modes](each unit="rad/s") "Angular frequency of each mode";
  initial equation
    for j in 1:axes loop
      der(mean[j]) = 0;
    end for;
    for k in 1:modes loop
      for j in 1:axes loop
        der(z[k,j]) = 0;
        der(v[k,j]) = 0;
      end for;
    end for;
  equation
    y = Constants.um*y_um;
    for j in 1:axes loop
      time_constant*der(mean[j]) = u_um[j] - mean[j];
      way[j] = (u_um[j] - mean[j])/amplitude[j];
    end for;
    time_constant*der(power) = Functions.rowProduct(way, 1, way)/axes - power;
    s = min(max(power, 0)^(0.5*exponent), 1.5);
    for k in 1:modes loop
      w[k] = 2*Constants.pi*frequency[k]*(1 + frequency_shift[k]*s);
      for j in 1:axes loop
        der(z[k,j]) = w[k]*v[k,j];
        der(v[k,j]) = w[k]*(u_um[j] - z[k,j] - 2*damping[k]*(1 + damping_growth[k]*s)*v[k,j]);
      end for;
    end for;
    for i in 1:axes loop
      total[1,i] = Functions.rowProduct(direct, i, u_um);
      for k in 1:modes loop
        total[k + 1,i] = total[k,i] + Functions.rowProduct(residue, (k - 1)*axes + i, z[k,:])
          + Functions.rowProduct(rate_residue, (k - 1)*axes + i, v[k,:]);
      end for;
      y_um[i] = total[modes + 1,i];
    end for;
    annotation(Icon(graphics={Line(points={{-80,-80},{-80,80}}, color={192,192,192}), Line(points={{-80,-80},{80,-80}}, color={192,192,192}), Line(points={{-80,-70},{-73,-70},{-65,47},{-61,67},{-49,-9},{-37,70},{-25,9},{-22,15},{-13,64},{0,18},{11,57},{14,54},{24,24},{35,53},{38,51},{48,28},{51,30},{60,49},{63,47},{72,31},{75,32},{80,41}}, color={0,0,127}, thickness=0.5)}),
      Documentation(info="<html><p>Component <code>softening-modes</code>. Modes that all axes share, with frequency and damping that follow the amplitude.</p><p><code>y[i] = sum(direct[i,j]*x[j]) + sum(residue[k,i,j]*z[k,j] + rate_residue[k,i,j]*z[k,j]'/w[k]); z'' + 2*d*w*z' + w^2*z = w^2*x; w = 2*pi*frequency*(1 + frequency_shift*s); d = damping*(1 + damping_growth*s); s = min(a^exponent, 1.5); a^2 = mean(v[j]/amplitude[j]^2); time_constant*m' = x - m; time_constant*v' = (x - m)^2 - v</code></p><table border='1'><tr><th>parameter</th><th>unit</th><th>start</th><th>least</th><th>greatest</th><th>meaning</th></tr><tr><td>axes` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>8</td><td>Number of coupled axes</td></tr><tr><td>entries` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of entries of a matrix</td></tr><tr><td>modes` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>64</td><td>Number of modes</td></tr><tr><td>residues` (structure)</td><td>1</td><td>by its lists</td><td>1</td><td>4096</td><td>Entries of all modes' matrices</td></tr><tr><td>direct</td><td>1</td><td>required</td><td></td><td></td><td>Motion per motion outside the listed modes, row by row</td></tr><tr><td>frequency</td><td>Hz</td><td>required</td><td>0</td><td></td><td>Undamped natural frequency of each mode, small motion</td></tr><tr><td>damping</td><td>1</td><td>required</td><td>0</td><td></td><td>Damping ratio of each mode, small motion</td></tr><tr><td>frequency_shift</td><td>1</td><td>required</td><td></td><td></td><td>Relative change of each mode's frequency at `amplitude`, negative where it softens</td></tr><tr><td>damping_growth</td><td>1</td><td>required</td><td></td><td></td><td>Relative change of each mode's damping ratio at `amplitude</td></tr><tr><td>residue</td><td>1</td><td>required</td><td></td><td></td><td>Static motion per motion through each mode, row by row, mode after mode</td></tr><tr><td>rate_residue</td><td>1</td><td>required</td><td></td><td></td><td>Motion per rate of each mode over its angular frequency, row by row, mode after mode</td></tr><tr><td>amplitude</td><td>{position}</td><td>required</td><td>0</td><td></td><td>Rms of each axis' motion before the coupling at which shift and growth are given</td></tr><tr><td>exponent</td><td>1</td><td>1</td><td>0</td><td></td><td>Exponent of the amplitude in shift and growth</td></tr><tr><td>time_constant</td><td>s</td><td>0.1</td><td>0</td><td></td><td>Time constant of the running rms</td></tr></table><p>Source: L. Gaul, R. Nitsche, Appl. Mech. Rev. 54 (2001) 93-106.</p></html>"));
  end SofteningModes;
  annotation(Documentation(info="<html><p>Several axes at once.</p></html>"));
end Coupling;

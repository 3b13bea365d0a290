within Piezoloop.Blocks;
package Coupling "Several axes at once"
  block CommandCoupling "Static coupling from the neighbours' commands"
    parameter Integer axes(min = 2, max = 4) "Number of coupled axes";
    parameter Integer entries(min = 4, max = 16) "Number of entries of the matrix";
    parameter Real matrix[entries](each unit="um/V") "Motion per command of the neighbour, row by row, zero on the diagonal";
    Interfaces.PositionInput u[axes] "Position of each axis in front";
    Interfaces.PositionOutput y[axes] "Position of each axis behind";
    Interfaces.CommandInput command[axes] "Command of each axis";
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
  equation
    y = Constants.um*y_um;
    for i in 1:axes loop
      y_um[i] = u_um[i] + Functions.rowProduct(matrix, i, command);
    end for;
    annotation(Documentation(info="<html><p>Component <code>command-coupling</code>:</p><p><code>y[i] = x[i] + sum(matrix[i,j]*u[j])</code></p></html>"));
  end CommandCoupling;

  block DisplacementCoupling "Coupling from the neighbours' motion, with their dynamics"
    parameter Integer axes(min = 2, max = 8) "Number of coupled axes";
    parameter Integer entries(min = 4, max = 64) "Number of entries of the matrix";
    parameter Real matrix[entries](each unit="1") "Motion per motion of the neighbour, row by row, zero on the diagonal";
    Interfaces.PositionInput u[axes] "Position of each axis in front";
    Interfaces.PositionOutput y[axes] "Position of each axis behind";
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
  equation
    y = Constants.um*y_um;
    for i in 1:axes loop
      y_um[i] = u_um[i] + Functions.rowProduct(matrix, i, u_um);
    end for;
    annotation(Documentation(info="<html><p>Component <code>displacement-coupling</code>:</p><p><code>y[i] = x[i] + sum(matrix[i,j]*x[j])</code></p></html>"));
  end DisplacementCoupling;

  block ModeCoupling "Coupling from the neighbours' commands through a mode of each neighbour"
    parameter Integer axes(min = 2, max = 4) "Number of coupled axes";
    parameter Integer entries(min = 4, max = 16) "Number of entries of the matrix";
    parameter Real matrix[entries](each unit="um/V") "Motion per command of the neighbour, row by row, zero on the diagonal";
    parameter Real frequency[axes](each unit="Hz", each min = 0) "Undamped natural frequency of each axis' mode";
    parameter Real damping[axes](each unit="1", each min = 0) "Damping ratio of each axis' mode";
    Interfaces.PositionInput u[axes] "Position of each axis in front";
    Interfaces.PositionOutput y[axes] "Position of each axis behind";
    Interfaces.CommandInput command[axes] "Command of each axis";
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
    annotation(Documentation(info="<html><p>Component <code>mode-coupling</code>:</p><p><code>y[i] = x[i] + sum(matrix[i,j]*z[j]); z'' + 2*damping*w*z' + w^2*z = w^2*u; w = 2*pi*frequency</code></p></html>"));
  end ModeCoupling;

  block ModalMatrix "Linear structure with several inputs and outputs: modes that all axes share"
    parameter Integer axes(min = 1, max = 8) "Number of coupled axes";
    parameter Integer entries(min = 1, max = 64) "Number of entries of a matrix";
    parameter Integer modes(min = 1, max = 64) "Number of modes";
    parameter Integer residues(min = 1, max = 4096) "Entries of all modes' matrices";
    parameter Real direct[entries](each unit="1") "Motion per motion of what has no mode here, row by row";
    parameter Real frequency[modes](each unit="Hz", each min = 0) "Undamped natural frequency of each mode";
    parameter Real damping[modes](each unit="1", each min = 0) "Damping ratio of each mode";
    parameter Real residue[residues](each unit="1") "Static motion per motion through each mode, row by row, mode after mode";
    parameter Real rate_residue[residues](each unit="1") "Motion per rate of each mode over its angular frequency, row by row, mode after mode";
    Interfaces.PositionInput u[axes] "Position of each axis in front";
    Interfaces.PositionOutput y[axes] "Position of each axis behind";
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
    annotation(Documentation(info="<html><p>Component <code>modal-matrix</code>:</p><p><code>y[i] = sum(direct[i,j]*x[j]) + sum(residue[k,i,j]*z[k,j] + rate_residue[k,i,j]*z[k,j]'/w[k]); z'' + 2*damping*w*z' + w^2*z = w^2*x; w = 2*pi*frequency</code></p></html>"));
  end ModalMatrix;

  block OpticsJacobian "From the angles of several mirrors to the coordinates of the spots on the sensors"
    parameter Integer axes(min = 2, max = 32) "Number of coupled axes";
    parameter Integer entries(min = 4, max = 1024) "Number of entries of the matrix";
    parameter Real matrix[entries](each unit="um/V") "Jacobian, row by row";
    parameter Real offset[axes](each unit="um") "Coordinates at zero angles";
    Interfaces.PositionInput u[axes] "Position of each axis in front";
    Interfaces.PositionOutput y[axes] "Position of each axis behind";
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
  equation
    y = Constants.um*y_um;
    for i in 1:axes loop
      y_um[i] = offset[i] + Functions.rowProduct(matrix, i, u_um);
    end for;
    annotation(Documentation(info="<html><p>Component <code>optics-jacobian</code>:</p><p><code>p[i] = offset[i] + sum(matrix[i,j]*theta[j])</code></p></html>"));
  end OpticsJacobian;

  block PsdPincushion "Pincushion distortion of a position-sensitive detector"
    parameter Integer axes(min = 2, max = 2) "Number of axes, 2";
    parameter Real distortion(unit="1") "Relative shift at half_size on an axis";
    parameter Real half_size(unit="um", min = 0) "Half the edge of the detector";
    Interfaces.PositionInput u[axes] "Position of each axis in front";
    Interfaces.PositionOutput y[axes] "Position of each axis behind";
  protected
    Real u_um[axes](each unit="um") = u/Constants.um "u in um";
    Real y_um[axes](each unit="um") "y in um";
  equation
    y = Constants.um*y_um;
    for i in 1:axes loop
      y_um[i] = u_um[i]*(1 + distortion*(u_um[1]^2 + u_um[2]^2)/half_size^2);
    end for;
    annotation(Documentation(info="<html><p>Component <code>psd-pincushion</code>:</p><p><code>q[i] = p[i]*(1 + distortion*(p[1]^2 + p[2]^2)/half_size^2)</code></p></html>"));
  end PsdPincushion;
end Coupling;

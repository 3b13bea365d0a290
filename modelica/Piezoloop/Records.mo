within Piezoloop;
package Records "Measured and printed values of specimens"
  extends Icons.Package;

  record EvcY "Elliptical vibration cutting device, axis Y, 0 to 120 V"
    extends Icons.Record;
    parameter Real prandtl_ishlinskii_r[10](each unit="V") = {0, 6, 12, 18, 24, 30, 36, 42, 48, 54} "Threshold of each play, increasing from 0 (printed: 0, 6, ..., 54 V)";
    parameter Real prandtl_ishlinskii_w[10](each unit="um/V") = {0.01354, 0.0279, 0, 0.004014, 0.007765, 0, 0, 0, 0, 0} "Weight of each play; the first k add up to 0 or more (printed, um/V: quadratic programming on the 1 Hz loop)";
    parameter Real mode_frequency(unit="Hz") = 482.6 "Undamped natural frequency (printed: finite elements, first resonance)";
    parameter Real mode_damping(unit="1") = 0.02 "Damping ratio; 1 is critical (assumed: usual for flexures; the paper does not give it)";
    annotation(Documentation(info="<html><p>Record <code>evc-y</code> of the tool; the source stands at each value.</p></html>"));
  end EvcY;

  record EvcZ "Elliptical vibration cutting device, axis Z, 0 to 120 V"
    extends Icons.Record;
    parameter Real prandtl_ishlinskii_r[10](each unit="V") = {0, 6, 12, 18, 24, 30, 36, 42, 48, 54} "Threshold of each play, increasing from 0 (printed: 0, 6, ..., 54 V)";
    parameter Real prandtl_ishlinskii_w[10](each unit="um/V") = {0.02523, 0.04579, 0, 0.004541, 0.001636, 0, 0, 0, 0, 0} "Weight of each play; the first k add up to 0 or more (printed, um/V: quadratic programming on the 1 Hz loop)";
    parameter Real mode_frequency(unit="Hz") = 290.7 "Undamped natural frequency (printed: finite elements, first resonance)";
    parameter Real mode_damping(unit="1") = 0.02 "Damping ratio; 1 is critical (assumed: usual for flexures; the paper does not give it)";
    annotation(Documentation(info="<html><p>Record <code>evc-z</code> of the tool; the source stands at each value.</p></html>"));
  end EvcZ;

  record P75221c "PI P-752.21C nanopositioning stage, 35 um, with amplifier and capacitive sensor"
    extends Icons.Record;
    parameter Real mode_frequency(unit="Hz") = 2100.0 "Undamped natural frequency (maker's data, quoted in the paper's section on the rig)";
    parameter Real mode_damping(unit="1") = 0.02 "Damping ratio; 1 is critical (assumed: usual for flexures; neither maker nor paper gives it)";
    parameter Real load_force_stiffness(unit="N/um") = 20.0 "Stiffness of the actuator with its flexure (maker's data, quoted in the paper's section on the rig)";
    parameter Real amplifier_lag_bandwidth(unit="Hz") = 3000.0 "Frequency at which the gain has fallen by 3 dB (the paper's section on the rig)";
    parameter Real amplifier_lag_gain(unit="1") = 10 "Gain at low frequency (the paper's section on the rig)";
    parameter Real sensor_lag_bandwidth(unit="Hz") = 10000.0 "Frequency at which the reading has fallen by 3 dB (maker's data, quoted in the paper's section on the rig)";
    parameter Real sensor_noise_rms(unit="um") = 0.0001 "Standard deviation of the white part per internal step (maker's resolution, read as the rms of the white noise)";
    annotation(Documentation(info="<html><p>Record <code>p-752-21c</code> of the tool; the source stands at each value.</p></html>"));
  end P75221c;

  record T434A4201 "Piezo bimorph T434-A4-201, 236 um, Bouc-Wen hysteresis in front of a light mode"
    extends Icons.Record;
    parameter Real bouc_wen_gain(unit="um/V") = 24.373 "Position per command without hysteresis (printed as D, fitted by a particle swarm)";
    parameter Real bouc_wen_alpha(unit="1") = 0.1947 "Share of the gain that the hysteresis removes after a reversal (printed, fitted by a particle swarm)";
    parameter Real bouc_wen_beta(unit="1/V") = 3.3626 "Decay of h towards zero on both branches (printed, fitted by a particle swarm; per volt)";
    parameter Real bouc_wen_gamma(unit="1/V") = -2.8526 "Decay of h that depends on the direction (printed, fitted by a particle swarm; per volt)";
    parameter Real mode_frequency(unit="Hz") = 405.06 "Undamped natural frequency (sqrt(K/M)/2pi of the printed M = 1.8e-3 kg, K = 1.1659e4 N/m)";
    parameter Real mode_damping(unit="1") = 0.00036 "Damping ratio; 1 is critical (B/(2 sqrt(K M)) of the printed B = 3.3e-3 N.s/m)";
    parameter Real load_force_stiffness(unit="N/m") = 11659.0 "Stiffness of the actuator with its flexure (printed K = 1.1659e4 N/m, of the second-order model of the tip)";
    annotation(Documentation(info="<html><p>Record <code>t434-a4-201</code> of the tool; the source stands at each value.</p></html>"));
  end T434A4201;
  annotation(Documentation(info="<html><p>Records of parameters. Pass their fields to the blocks: <code>Mechanics.Mode(frequency = specimen.mode_frequency)</code>.</p></html>"));
end Records;

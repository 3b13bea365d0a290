"""PI's own client, PIPython, works with the emulated instrument: identify, servo, move, wait, errors, stop; wave
generator, data recorder, parameters and analog inputs. The argument is a port of this computer, or a serial line."""

import math
import sys

from pipython import GCSDevice, GCSError, datarectools, gcserror, pitools
from pipython.pidevice.interfaces.piserial import PISerial
from pipython.pidevice.interfaces.pisocket import PISocket

where = sys.argv[1]
pi = GCSDevice(gateway=PISocket("127.0.0.1", int(where)) if where.isdigit() else PISerial(where, 115200))
assert "emulated GCS 2.0" in pi.qIDN(), pi.qIDN()
assert pi.qCSV() == 2.0 and pi.axes == ["1"] and pi.numaxes == 1
assert pi.HasMOV() and pi.HasqPOS() and not pi.HasFRF()
pitools.startup(pi)
assert pi.qSVO()["1"] is True
least, greatest = pi.qTMN()["1"], pi.qTMX()["1"]
assert least < 0 < greatest, (least, greatest)
for target in (1.5, 3.25, 0.25):
    pi.MOV("1", target)
    pitools.waitontarget(pi, "1", timeout=60)
    assert abs(pi.qPOS("1")["1"] - target) < 2e-3 * (greatest - least) and pi.qMOV("1")["1"] == target
    assert pi.qONT("1")["1"] is True
pi.MVR("1", 0.5)
assert pi.qMOV("1")["1"] == 0.75
for bad, error in (
    (lambda: pi.MOV("1", greatest + 1), gcserror.E7_PI_CNTR_POS_OUT_OF_LIMITS),
    (lambda: pi.MOV("3", 0), gcserror.E15_PI_CNTR_INVALID_AXIS_IDENTIFIER),
    (lambda: pi.send("XYZ 1"), gcserror.E2_PI_CNTR_UNKNOWN_COMMAND),
    (lambda: pi.StopAll(), gcserror.E10_PI_CNTR_STOP),
):
    try:
        bad()
    except GCSError as said:
        assert said == error, said
    else:
        raise AssertionError(error)
pi.SVO("1", False)
pi.SVA("1", 5)
assert pi.qSVA("1")["1"] == 5 and not pi.IsMoving("1")["1"] and pi.IsControllerReady()
try:
    pi.MOV("1", 1)
except GCSError as said:
    assert said == gcserror.E5_PI_CNTR_MOVE_WITHOUT_REF_OR_NO_SERVO, said
else:
    raise AssertionError("a move with the servo off")

# Wave generator: a sine and a table of points, read back, played twice while the data recorder runs.
pi.SVO("1", True)
cycle = pi.qSPA(1, 0x0E000200)[1][0x0E000200]
assert pi.qTWG() == 1 and pi.qTNR() == 8
pi.WAV_SIN_P(table=1, firstpoint=0, numpoints=200, append="X", center=100, amplitude=2.0, offset=1.0, seglength=200)
assert pi.qWAV(1, 1)[1][1] == 200
sine = [2.0 - math.cos(2 * math.pi * k / 200) for k in range(200)]
pi.qGWD(1, 1, 200)
while pi.bufstate is not True:
    pass
assert max(abs(a - b) for a, b in zip(pi.bufdata[0], sine)) < 1e-5
pitools.writewavepoints(pi, 2, sine, bunchsize=50)
assert pi.qWAV(2, 1)[2][1] == 200
pi.WSL(1, 2)
pi.WGC(1, 2)
pi.WTR(1, 2, 0)
pi.WOS(1, 0.5)
assert pi.qWSL(1)[1] == 2 and pi.qWGC(1)[1] == 2 and pi.qWTR(1)[1][0] == 2 and pi.qWOS(1)[1] == 0.5
pi.MOV("1", sine[0] + 0.5)
pitools.waitontarget(pi, "1", timeout=60)
recorder = datarectools.Datarecorder(pi)
assert abs(recorder.servotime - cycle) < 1e-12 and recorder.maxnumvalues == 32768
recorder.numvalues = 400
recorder.samplerate = 2
recorder.sources = ["1", "1", "1"]
recorder.options = [1, 2, 7]
recorder.trigsources = 0
recorder.arm()
assert pi.qDRC([1, 2, 3]) == {1: ["1", 1], 2: ["1", 2], 3: ["1", 7]}, pi.qDRC([1, 2, 3])
pi.WGO(1, 1)
assert pi.IsGeneratorRunning(1)[1]
try:
    pi.MOV("1", 1)
except GCSError as said:
    assert said == gcserror.E73_PI_CNTR_WAVE_GENERATOR_ACTIVE, said
else:
    raise AssertionError("a move while the generator runs")
pitools.waitonwavegen(pi, 1, timeout=60)
header, (target, position, voltage) = recorder.getdata(timeout=60)
assert abs(header["SAMPLE_TIME"] - 2 * cycle) < 1e-9 and header["NDATA"] == 400, header
assert max(abs(a - b - 0.5) for a, b in zip(target, sine + sine)) < 1e-5
assert max(position) > 1.9 and max(voltage) - min(voltage) > 0.5
# Parameters of the servo; a notch filter is protected.
ti = pi.qSPA("1", 0x07000301)["1"][0x07000301]
pi.SPA("1", 0x07000301, 2 * ti)
assert abs(pi.qSPA("1", 0x07000301)["1"][0x07000301] / ti - 2) < 1e-5
pi.RPA()
assert abs(pi.qSPA("1", 0x07000301)["1"][0x07000301] / ti - 1) < 1e-5
for command, error in (
    (lambda: pi.SPA("1", 0x08000200, 0.05), gcserror.E60_PI_CNTR_PARAM_PROTECTION),
    (lambda: pi.SPA("1", 0x12345678, 1), gcserror.E54_PI_CNTR_UNKNOWN_PARAMETER),
    (lambda: pi.SPA("1", 0x0E000200, 1), gcserror.E64_PI_CNTR_READ_ONLY_PARAMETER),
):
    try:
        command()
    except GCSError as said:
        assert said == error, said
    else:
        raise AssertionError(error)
pi.CCL(1, "advanced")
pi.SPA("1", [0x08000100], [40.0])
pi.SPA("1", [0x08000200], [0.05])
pi.CCL(0)
assert pi.qTSC() == 2 and abs(pi.qTSP(1)[1] - pi.qPOS("1")["1"]) < 0.5
# The analog input, at which there are 4 V: normalized, scaled, and as what the axis follows.
pi.CCL(1, "advanced")
pi.SPA([2, 2], [0x02000200, 0x02000300], [1.0, 0.05])
assert abs(pi.qTNS(2)[2] - 40.0) < 1e-3 and abs(pi.qTSP(2)[2] - 3.0) < 1e-5 and pi.qTAD(2)[2] in (45874, 45875)
pi.AOS("1", 0.25)
assert pi.HasAOS() and pi.qAOS("1")["1"] == 0.25
pi.SPA("1", 0x06000500, 2)
pi.CCL(0)
pitools.waitontarget(pi, "1", timeout=60)
assert abs(pi.qMOV("1")["1"] - 3.25) < 1e-5 and abs(pi.qPOS("1")["1"] - 3.25) < 2e-3 * (greatest - least)
for move in (lambda: pi.MOV("1", 1), lambda: pi.WGO(1, 1)):
    try:
        move()
    except GCSError as said:
        assert said == gcserror.E72_PI_CNTR_ANALOG_TARGET_ACTIVE, said
    else:
        raise AssertionError("a move while the axis follows its analog input")
try:
    pi.SPA("1", 0x06000500, 0)
except GCSError as said:
    assert said == gcserror.E60_PI_CNTR_PARAM_PROTECTION, said
else:
    raise AssertionError("a protected parameter")
pi.CCL(1, "advanced")
pi.SPA("1", 0x06000500, 0)
pi.CCL(0)
pi.MOV("1", 1)
assert pi.qMOV("1")["1"] == 1
print("PIPython", least, greatest)

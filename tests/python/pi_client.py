"""PI's own client, PIPython, works with the emulated instrument: identify, servo, move, wait, errors, stop."""

import sys

from pipython import GCSDevice, GCSError, gcserror, pitools
from pipython.pidevice.interfaces.pisocket import PISocket

pi = GCSDevice(gateway=PISocket("127.0.0.1", int(sys.argv[1])))
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
print("PIPython", least, greatest)

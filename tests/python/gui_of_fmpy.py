"""FMPy's graphical user interface, offscreen: loads FMUs, shows their documentation, validates and
simulates them with an input file, and compares the result with ours. Whatever it shows or prints as a
warning or an error ends the script.

Arguments: for each FMU its file, the file of its inputs, our run. Files *.png show the pages.
"""

import os
import sys
import warnings
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("QTWEBENGINE_DISABLE_SANDBOX", "1")
os.environ.setdefault("QTWEBENGINE_CHROMIUM_FLAGS", "--disable-gpu --log-level=3")
warnings.simplefilter("error")

try:
    from PySide6.QtCore import QCoreApplication, QEventLoop, Qt, QTimer, qInstallMessageHandler
    from PySide6.QtCore import QSettings, QtMsgType
    from PySide6.QtWebEngineCore import QWebEnginePage
    from PySide6.QtWidgets import QApplication, QMessageBox
except ImportError as error:
    print("SKIPPED: Qt does not load:", error)
    sys.exit()

import numpy as np
from fmpy import read_model_description
from fmpy.util import read_csv

complaints = []
version = ""


def told_by_qt(kind, context, message):
    # The machine's graphics are not the FMU's affair; FMI 3.0 has no model.png, which FMPy wants.
    graphics = ("RHI", "QRhi", "GPU", "Vulkan", "propagateSizeHints", "Sandboxing", "QFont")
    if kind == QtMsgType.QtDebugMsg or any(word in message for word in graphics):
        return
    if version == "3.0" and message == "QPixmap::scaled: Pixmap is a null pixmap":
        return
    complaints.append(f"Qt: {message}")


qInstallMessageHandler(told_by_qt)
QSettings.setPath(QSettings.Format.NativeFormat, QSettings.Scope.UserScope, os.getcwd())
QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
application = QApplication(sys.argv[:1])

from fmpy.gui.MainWindow import MainWindow  # noqa: E402

informed = []
QMessageBox.information = lambda parent, title, text: informed.append(title)
for name in ("warning", "critical", "question"):
    setattr(QMessageBox, name, lambda parent, title, text: complaints.append(f"{title}: {text}"))


class Page(QWebEnginePage):
    """A page whose console is heard."""

    def javaScriptConsoleMessage(self, level, message, line, source):
        complaints.append(f"page: {message} ({source}:{line})")


def wait(signal, what, seconds=120):
    """What the signal brings."""
    loop, brought = QEventLoop(), []
    signal.connect(lambda *values: (brought.append(values), loop.quit()))
    QTimer.singleShot(seconds * 1000, loop.quit)
    yield
    if not brought:
        loop.exec()
    assert brought, f"{what} did not come in {seconds} s"
    yield brought[0]


def during(signal, what, action):
    waiting = wait(signal, what)
    next(waiting)
    action()
    return next(waiting)


def text_of(page):
    loop, text = QEventLoop(), []
    page.toPlainText(lambda plain: (text.append(plain), loop.quit()))
    if not text:
        loop.exec()
    return text[0]


def picture(window, name):
    loop = QEventLoop()
    QTimer.singleShot(400, loop.quit)
    loop.exec()
    window.grab().save(name)


def columns(run):
    """The outputs by element: a matrix for an array of FMI 3.0."""
    for name in run.dtype.names[1:]:
        values = run[name]
        if values.ndim == 1:
            yield name, values
        else:
            for i in range(values.shape[1]):
                yield f"{name}[{i + 1}]", values[:, i]


def show(fmu, inputs, ours):
    global version
    version = read_model_description(fmu).fmiVersion
    window = MainWindow()
    window.resize(1200, 800)
    ui = window.ui
    ui.webEngineView.setPage(Page(ui.webEngineView))
    loaded, = during(ui.webEngineView.loadFinished, "documentation", lambda: window.load(str(fmu)))
    assert loaded, "the documentation does not load"
    name = window.modelDescription.modelName
    documentation = text_of(ui.webEngineView.page())
    assert name in documentation, documentation
    for variable in window.modelDescription.modelVariables:
        if variable.causality in ("input", "output"):
            base = variable.name.split("[")[0]
            assert base in documentation, f"{variable.name} is not in the documentation"
    ui.actionShowDocumentation.trigger()
    picture(window, f"{fmu.stem}-documentation.png")
    ui.actionValidateFMU.trigger()
    assert informed.pop() == "Validation successful"

    ours = read_csv(ours)
    time = ours["time"]
    window.stopTimeLineEdit.setText(repr(float(time[-1])))
    ui.outputIntervalRadioButton.setChecked(True)
    ui.outputIntervalLineEdit.setText(repr(float(time[1] - time[0])))
    ui.inputCheckBox.setChecked(True)
    ui.inputFilenameLineEdit.setText(str(inputs))
    ui.debugLoggingCheckBox.setChecked(True)
    ui.actionSimulate.trigger()
    if window.simulationThread is not None:
        thread = window.simulationThread
        next(waiting := wait(thread.finished, "the end of the simulation"))
        thread.isFinished() or next(waiting)
        application.processEvents()
    picture(window, f"{fmu.stem}-result.png")
    complaints.extend(f"{level}: {text}" for level, text in window.log.messages
                      if level in ("warning", "error"))
    assert window.result is not None, window.log.messages
    compared = 0
    for name, values in columns(window.result):
        if name in ours.dtype.names and name in outputs_of(window):
            difference = np.abs(values - ours[name]).max()
            assert len(values) == len(time), name
            assert difference <= 1e-9 * np.ptp(ours[name]), (name, difference)
            compared += np.ptp(ours[name]) > 0.0
    assert compared >= 2, compared
    print(f"FMPy's GUI, {fmu.name}: documentation, validation, {len(time)} rows as ours")
    window.close()


def outputs_of(window):
    for variable in window.modelDescription.modelVariables:
        if variable.causality == "output":
            yield variable.name
            yield from (f"{variable.name}[{i + 1}]" for i in range(2))


arguments = [Path(argument).resolve() for argument in sys.argv[1:]]
for files in zip(*[iter(arguments)] * 3, strict=True):
    show(*files)
for complaint in complaints:
    print(complaint)
sys.stdout.flush()
# Qt's own teardown is not under test.
os._exit(1 if complaints else 0)

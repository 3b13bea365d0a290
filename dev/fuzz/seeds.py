"""Writes the inputs that mutations start from, `corpus/<target>/`, by the tools that users have.

Needs numpy, scipy, pandas, pyarrow, asammdf, h5py and npTDMS, and the FMUs and the gap.json that the tool makes:
seeds.py PIEZOLOOP FOLDER_WITH_GAP_JSON
"""

import json
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
from asammdf import MDF, Signal
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from scipy.io import savemat

tool, gap = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
here = Path(__file__).resolve().parent
root = here.parents[1]


def into(target: str, name: str, content: bytes | str) -> None:
    folder = here / "corpus" / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)


def stored(entries: dict[str, bytes], path: Path, method: int = zipfile.ZIP_STORED) -> bytes:
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, content in entries.items():
            archive.writestr(zipfile.ZipInfo(name), content, method)
    return path.read_bytes()


def blueprints() -> None:
    for name in ["stage", "controller", "gain"]:
        into("blueprint", f"{name}.toml", (root / f"tests/blueprints/{name}.toml").read_bytes())
    for name in ["p3", "p2", "evc"]:
        into("blueprint", f"{name}.toml", (root / f"rigs/{name}.toml").read_bytes())
    into("system-plan", "loop.toml", (root / "examples/03_system/loop.toml").read_bytes())
    into("system-plan", "all.toml", """name = "closed loop"
start = 0.0
stop = 0.1
step = 1e-4
algorithm = "iteration"
order = ["controller", "plant"]
[iteration]
tolerance = 1e-6
[fmus]
plant = "plant.fmu"
controller = { file = "controller.fmu", step = 1e-3, start = { "k" = 2.0, "on" = true, "s" = "x" } }
[connections]
"plant.command[1]" = "controller.command[1]"
"controller.measured[1]" = { from = "plant.position[1]", factor = 1e-6, convert = false }
[inputs]
"controller.reference[1]" = "reference[1]"
[record]
position = "plant.position[1]"
""")


def descriptions(work: Path) -> None:
    for version in ["2", "3"]:
        for blueprint in ["gain", "controller"]:
            fmu = work / f"{blueprint}{version}.fmu"
            subprocess.run([tool, "pack", root / f"tests/blueprints/{blueprint}.toml", "--fmi", version, "-o", fmu],
                           check=True, capture_output=True)
            with zipfile.ZipFile(fmu) as archive:
                xml = archive.read("modelDescription.xml")
                others = {name: archive.read(name)[:2000] for name in archive.namelist()
                          if name.startswith("resources/") and not name.endswith("/")}
                binary = next(name for name in archive.namelist() if name.startswith("binaries/"))
            into("model-description", f"{blueprint}{version}.xml", xml)
            entries = {"modelDescription.xml": xml, binary: b"\x7fELF\x02\x01\x01" + bytes(57), **others}
            for target in ["fmu-archive", "fmu-unpacked"]:
                into(target, f"{blueprint}{version}.fmu", stored(entries, work / "a.zip"))
                into(target, f"{blueprint}{version}-packed.fmu",
                     stored(entries, work / "a.zip", zipfile.ZIP_DEFLATED))


SSD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
  xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
  xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping" version="1.0" name="loop">
  <ssd:System name="loop">
    <ssd:Connectors>
      <ssd:Connector name="r" kind="input"><ssc:Real unit="um"/></ssd:Connector>
      <ssd:Connector name="y" kind="output"><ssc:Real unit="um"/></ssd:Connector>
    </ssd:Connectors>
    <ssd:ParameterBindings>
      <ssd:ParameterBinding source="start.ssv"/>
      <ssd:ParameterBinding><ssd:ParameterValues>
        <ssv:ParameterSet version="1.0" name="inner"><ssv:Parameters>
          <ssv:Parameter name="plant.k"><ssv:Real value="2.0"/></ssv:Parameter>
        </ssv:Parameters></ssv:ParameterSet>
      </ssd:ParameterValues></ssd:ParameterBinding>
    </ssd:ParameterBindings>
    <ssd:Elements>
      <ssd:Component name="plant" source="resources/plant.fmu" type="application/x-fmu-sharedlibrary">
        <ssd:Connectors>
          <ssd:Connector name="u" kind="input"><ssc:Real unit="V"/></ssd:Connector>
          <ssd:Connector name="y" kind="output"><ssc:Real unit="um"/></ssd:Connector>
          <ssd:Connector name="k" kind="parameter"><ssc:Real/></ssd:Connector>
        </ssd:Connectors>
      </ssd:Component>
      <ssd:System name="inside">
        <ssd:Connectors>
          <ssd:Connector name="r" kind="input"><ssc:Real unit="um"/></ssd:Connector>
          <ssd:Connector name="u" kind="output"><ssc:Real unit="V"/></ssd:Connector>
        </ssd:Connectors>
        <ssd:Elements>
          <ssd:Component name="law" source="resources/law.fmu">
            <ssd:Connectors>
              <ssd:Connector name="r" kind="input"><ssc:Real/></ssd:Connector>
              <ssd:Connector name="u" kind="output"><ssc:Real/></ssd:Connector>
            </ssd:Connectors>
          </ssd:Component>
        </ssd:Elements>
        <ssd:Connections>
          <ssd:Connection startConnector="r" endElement="law" endConnector="r"/>
          <ssd:Connection startElement="law" startConnector="u" endConnector="u"/>
        </ssd:Connections>
      </ssd:System>
    </ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startConnector="r" endElement="inside" endConnector="r"/>
      <ssd:Connection startElement="inside" startConnector="u" endElement="plant" endConnector="u">
        <ssc:LinearTransformation factor="2.0" offset="0.5"/>
      </ssd:Connection>
      <ssd:Connection startElement="plant" startConnector="y" endConnector="y"/>
    </ssd:Connections>
  </ssd:System>
  <ssd:Units>
    <ssc:Unit name="um"><ssc:BaseUnit m="1" factor="1e-6"/></ssc:Unit>
    <ssc:Unit name="V"><ssc:BaseUnit kg="1" m="2" s="-3" A="-1"/></ssc:Unit>
  </ssd:Units>
  <ssd:DefaultExperiment startTime="0" stopTime="0.1"/>
</ssd:SystemStructureDescription>
"""
SSV = """<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0" name="start">
  <ssv:Parameters>
    <ssv:Parameter name="plant.k"><ssv:Real value="1.5" unit="um"/></ssv:Parameter>
    <ssv:Parameter name="n"><ssv:Integer value="3"/></ssv:Parameter>
    <ssv:Parameter name="on"><ssv:Boolean value="true"/></ssv:Parameter>
    <ssv:Parameter name="s"><ssv:String value="text"/></ssv:Parameter>
    <ssv:Parameter name="e"><ssv:Enumeration value="item"/></ssv:Parameter>
  </ssv:Parameters>
  <ssv:Units><ssc:Unit name="um"><ssc:BaseUnit m="1" factor="1e-6"/></ssc:Unit></ssv:Units>
</ssv:ParameterSet>
"""
SSM = """<?xml version="1.0" encoding="UTF-8"?>
<ssm:ParameterMapping xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0">
  <ssm:MappingEntry source="a" target="plant.k"><ssc:LinearTransformation factor="2" offset="1"/></ssm:MappingEntry>
  <ssm:MappingEntry source="b" target="on"><ssc:BooleanMappingTransformation>
    <ssc:MapEntry source="true" target="false"/></ssc:BooleanMappingTransformation></ssm:MappingEntry>
</ssm:ParameterMapping>
"""


def systems(work: Path) -> None:
    into("ssp-structure", "loop.ssd", SSD)
    into("ssp-values", "start.ssv", SSV)
    into("ssp-values", "map.ssm", SSM)
    entries = {"SystemStructure.ssd": SSD.encode(), "start.ssv": SSV.encode(),
               "resources/plant.fmu": b"PK\x05\x06" + bytes(18), "resources/law.fmu": b""}
    into("ssp-archive", "loop.ssp", stored(entries, work / "b.zip"))
    into("ssp-archive", "packed.ssp", stored(entries, work / "b.zip", zipfile.ZIP_DEFLATED))


def dymola(time: np.ndarray, u: np.ndarray) -> bytes:
    """A result in four matrices of MATLAB 4."""
    def matrix(name: str, kind: int, rows: int, data: np.ndarray) -> bytes:
        head = struct.pack("<5i", kind, rows, data.size // rows, 0, len(name) + 1)
        return head + name.encode() + b"\0" + data.tobytes()

    def letters(texts: list[str]) -> np.ndarray:
        return np.frombuffer("".join(text.ljust(11) for text in texts).encode(), np.uint8)

    kind = letters(["Atrajectory", "1.1", "", "binTrans"]).reshape(4, 11).T.copy()
    info = np.array([[0, 1, 0, -1], [2, -2, 0, -1], [1, 1, 0, -1]], np.int32)
    return (matrix("Aclass", 51, 4, kind) + matrix("name", 51, 11, letters(["time", "m.x", "m.k"])) +
            matrix("description", 51, 11, letters(["[s]", "place [m]", ""])) + matrix("dataInfo", 20, 4, info) +
            matrix("data_1", 0, 1, np.ones(2)) + matrix("data_2", 0, 2, np.stack([time, u], 1)))


def tdms(bits: int, index: bytes, values: bytes) -> bytes:
    """A segment of two channels with a scale each."""
    def text(value: str) -> bytes:
        return struct.pack("<I", len(value)) + value.encode()

    def number(name: str, value: float) -> bytes:
        return text(name) + struct.pack("<Id", 10, value)

    listed = struct.pack("<I", 2)
    for channel in "uy":
        listed += text(f"/'g'/'{channel}'") + index + struct.pack("<I", 6)
        listed += number("wf_increment", 0.5) + text("NI_Number_Of_Scales") + struct.pack("<II", 7, 2)
        listed += text("NI_Scale[1]_Scale_Type") + struct.pack("<I", 0x20) + text("Linear")
        listed += number("NI_Scale[1]_Linear_Slope", 2.0) + number("NI_Scale[1]_Linear_Y_Intercept", 1.0)
        listed += text("NI_Scale[1]_Linear_Input_Source") + struct.pack("<II", 7, 0)
    lead = struct.pack("<IIQQ", 0xe | bits, 4713, len(listed) + len(values), len(listed))
    return b"TDSm" + lead + listed + values


# Texts as instruments and other programs write them, each with another guess.
TEXTS = {
    "scope.csv": "x-axis,1,2\nsecond,Volt,V\n-2E-3,0.5,1\n-1E-3,0.6,2\n0,0.7,3\n1E-3,0.8,2\n",
    "rigol.csv": "X,CH1,CH2,Start,Increment,\nSequence,VOLT,VOLT,-2E-3,1E-3\n0,0.5,1,\n1,0.6,2,\n2,0.7,3,\n",
    "preamble.csv": "#Device: ADP3450\n#Sample rate: 1000Hz\n#\n\nTime (s),Channel 1 (V)\n0,1\n0.001,2\n0.002,3\n",
    "semicolons.csv": ";Samples;3\n;Rate;1kHz\nt [ms];u [V];y [\u00b5m]\n0;1,5;0,1\n1;2,5;0,2\n2;3,5;0,3\n",
    "table.lvm": "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nDate\t2026/11/25\nTime\t12:00:00,5\n"
                 "***End_of_Header***\t\nChannels\t2\nDelta_X\t0,001\t0,001\n***End_of_Header***\n"
                 "X_Value\tVoltage\tPosition\tComment\n0,0\t1,0\t2,0\n0,001\t1,5\t2,5\n",
    "controller.dat": "# REM PI data\n#\n# VERSION = 1\n# TYPE = 1\n# SEPARATOR = 32\n# DIM = 2\n# SAMPLE_TIME = 50.0e-6\n"
                      "# NDATA = 3\n#\n# NAME0 = Target Position of axis1\n# NAME1 = Current Position of axis1\n#\n"
                      "# END_HEADER\n1.0 0.9\n1.1 1.0\n1.2 1.1\n",
    "dates.csv": "timestamp,u\n2026-11-25 12:00:00.000,1\n2026-11-25 12:00:00.001,2\n2026-11-25T12:00:00.002Z,3\n",
    "clock.txt": "Uhrzeit\tu\n12:59:59,999\t1,0\n13:00:00,000\t2,0\n13:00:00,001\t3,0\n",
    "blanks.txt": "# t u y\n0.000e+00 1.0  0.1\n1.000e-03 2.0  0.2\n2.000e-03 3.0  0.3\n",
    "jump.csv": "time,u\n0,1\n0.5,1\n0.5,2\n1,2\n",
    "pairs.csv": "X[s],u[V],X[s],y[um]\n0,1,0,0.1\n0.001,2,0.002,0.2\n0.002,3,0.004,0.3\n",
    "headless.csv": "0,1,2\n0.001,2,3\n0.002,3,4\n",
    "gaps.csv": "timestamps,u,note\n0,1,a\n0.001,,b\n0.002,3,\n,,\n",
}
DATASETS = {
    "all": '''rate = 2000
time = { column = "t", unit = "ms" }
[columns]
u = { unit = "V", description = "Command" }
y = { unit = "um" }
''',
    "time": 'time.column = "y"\n[time]\nunit = "us"\n',
    "names": '[columns."u [V]"]\nunit = "mV"\n[columns]\n"1" = {}\ny.unit = "°C"\n',
    "rate": 'rate = 1_000.0 # Hz\ncolumns = { y = { unit = "-" } }\n',
}
OSP_HEAD = """<?xml version="1.0" encoding="utf-8"?>
<OspSystemStructure xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure" version="0.1">"""
OSPS = {
    "loop": OSP_HEAD + """
<StartTime>0</StartTime><EndTime>1</EndTime><BaseStepSize>0.01</BaseStepSize><Algorithm>fixedStep</Algorithm>
<Simulators>
<Simulator name="p" source="p.fmu" stepSize="0.01"><InitialValues>
<InitialValue variable="k"><Real value="2"/></InitialValue><InitialValue variable="n"><Integer value="3"/></InitialValue>
<InitialValue variable="on"><Boolean value="true"/></InitialValue><InitialValue variable="s"><String value="x"/></InitialValue>
</InitialValues></Simulator>
<Simulator name="c" source="a%20b/c.fmu"/>
</Simulators>
<Functions><LinearTransformation name="f" factor="2" offset="1"/></Functions>
<Connections>
<VariableConnection><Variable simulator="c" name="u"/><Variable simulator="p" name="u"/></VariableConnection>
<SignalConnection><Variable simulator="p" name="y"/><Signal function="f" name="in"/></SignalConnection>
<SignalConnection><Signal function="f" name="out"/><Variable simulator="c" name="y"/></SignalConnection>
</Connections>
</OspSystemStructure>
""",
    "short": OSP_HEAD + """<Simulators><Simulator name="a" source="file:///a.fmu"/></Simulators></OspSystemStructure>""",
    "others": OSP_HEAD + """
<Simulators><Simulator name="law" source="proxyfmu://localhost?file=law.fmu" stepSize="0"/></Simulators>
<Functions><Sum name="s" inputCount="2"/><VectorSum name="v" inputCount="2" numericType="real" dimension="2"/></Functions>
<Connections><VariableGroupConnection><VariableGroup simulator="law" name="g"/><VariableGroup simulator="law" name="h"/>
</VariableGroupConnection><SignalGroupConnection><Signal function="v" name="in[0]"/><VariableGroup simulator="law" name="h"/>
</SignalGroupConnection></Connections>
</OspSystemStructure>
""",
    "prefixed": """<osp:OspSystemStructure xmlns:osp="urn:x" name="n"><!-- c --><osp:BaseStepSize>-1</osp:BaseStepSize>
<osp:Simulators><osp:Simulator name="a" source="../a.fmu" stepSize="1e400"/><osp:Simulator name="a" source=""/></osp:Simulators>
<osp:Connections><osp:VariableConnection><osp:Variable simulator="a" name="x"/></osp:VariableConnection></osp:Connections>
</osp:OspSystemStructure>
""",
}
TUNE = """mass=0.2,0.1..0.5
axis[1].mechanics.damping=0.05
A[1,2]=1e-3,-1..+1
stiffness
k = -2.5e6 , -1e7 .. 0
"""
SWEEPS = {
    "loop": """runs = 10
seed = 7
[loop]
plant = "evc"
controller = "c.toml"
reference = "r.csv"
from = 0.1
map = { "reference[1]" = "y" }
unit = { "y" = "um" }
coupling = "side-by-side"
step = 1e-4
stop = 1
all-effects = true
start = { "plant.k" = 2.0 }
new-instances = true
[vary]
"plant.*.frequency" = { tolerance = 0.05 }
"plant.a[1].gain" = { uniform = [0.9, 1.1] }
"plant.a[2].gain" = { log-uniform = [0.1, 10.0] }
"plant.d" = { normal = [0.05, 0.01] }
"controller.kp" = { grid = [0.01, 2] }
"controller.on" = { choice = [true, "x"] }
"plant.w" = { within = 0.05 }
"plant.seed" = { whole = [1, 9] }
""",
    "system": """[system]
file = "loop.ssp"
input = "r.csv"
parameters = ["n.ssv"]
step = 2e-5
stop = 1.0
[measure]
a = { column = "position[1]", minus = "reference[1]", take = "max" }
b = { column = "u", take = "rms" }
[vary]
"p.k" = { choice = [1, 2] }
""",
    "identify": """runs = 3
[identify]
machine = "p1-truth"
logs = ["t.csv"]
options = ["--model", "linear"]
[vary]
"machine.*.seed" = { whole = [1, 1000000] }
"option.plays" = { grid = ["5", "20"] }
""",
    "diagnose": """[diagnose]
model = "a.fmu"
logs = ["a.csv", "b.csv"]
holdout = ["c.csv"]
map = { u = "x" }
[vary]
"log" = { grid = ["m.csv", "t.csv"] }
""",
}
# What instruments answer, one after the other, behind the address.
GCS = ["PI, E-727.3CD, 12, 1.2\n", "0\n", "1 \n2\n", "1=-5 \n2=-5\n", "1=1e2 \n2=100\n", "1=0.1 \n2=0\n", "0\n"]
LINES = {
    "line-gcs": {
        "two": ("gcs://10.0.0.1?axes=1,2&timeout=0.05", [*GCS, "1=1 \n2=2\n0\n", "1=1.5 \n2=+2\n0", "\n", "0\n",
                                                       "1=1 \n2=2\n0\n", "1=1 \n2=3\n7\n", "1=1 \n2=2\n0\n"]),
        "one": ("gcs://[::1]:50000", ["PI\n", "5\n", "A B\n", "A=0\n", "A=1\n", "A=0.5\n", "0\n", "A=1\n0\n", "",
                                    "PI\n", "A=1\n0\n", "0\n", "A=2\n0\n", "A=2\n0\nA=3\n", "PI\n", "A=0\n"]),
        "open": ("gcs://10.0.0.1?mode=open&axes=X", ["PI\n", "0\n", "X\n", "X=0\n", "X=1\n", "X=0\n", "0\n", "X=1\n0\n", "X=1\n0\n",
                                                   "0\n", "X=1\n0\n", "", "Other\n"]),
    },
    "line-nv200": {
        "closed": ("nv200://10.0.0.1", ["NV200/D_NET>\n", "posmin,0.0\r\n\x11", "posmax,80\r\n\x11", "desc,TRITOR 100\r\n\x11",
                                      "meas,1.5\r\n\x11", "meas,1.5\r\n\x11", "\x11", "\x11", "\x11", "meas,2\r\n\x11",
                                      "cl,1\r\n\x11", "\x11", "meas,3\r\n\x11", "cl,1\r\n\x11", "error,4\r\n\x11"]),
        "open": ("nv200://10.0.0.1:23?mode=open&timeout=1", ["\xff\xfb\x01NV200\n", "avmin,-20\x11", "avmax,130\x11", "desc,x\x11", "meas,1\x11",
                                                          "", "NV200\n", "meas,1\x11", "\x11", "\x11", "\x11", "meas,1\x11",
                                                          "cl,0\x11", "", "NV200\n", "cl,1\x11", "set,2\x11"]),
    },
}
DRIVERS = {
    "good": "0|card 7|0 1 3 1|0 2 3 1 2|0 3 3 1 2 3|1 0 0|0 1 1 5|0 1 2 5",
    "refuses": "-7|the cable is off",
    "wrong": "0|-|5 0 0|0 2 3 1|0 1 255 1|0 1 3 nan|0 1 3 1 2 3 4|0 1 3 inf|2147483648 -1 0x7fffffff 1e400",
}


def journal() -> str:
    """A record without a controller: its description and rows, between signs that separate records."""
    names = ["time", "r", "p", "u", "bench.state", "bench.reason", "bench.missing", "bench.row", "bench.wake", "bench.work",
             "bench.round_trip", "bench.skipped", "bench.lost", "bench.late", "bench.duplicate", "bench.reordered", "bench.corrupt"]
    recipe = """version = 1
period_ns = 1000000
blend = 2
[start]
k = 0.5
[[axis]]
column = "r"
reference = "r"
position = "p"
measured = "p"
command = "u"
command_limits = [-1.0, inf]
command_rate = 100.0
safe = 0.0
safe_rate = 1e3
"""
    about = {"columns": [{"name": name, "unit": "um" if name == "p" else None, "description": ""} for name in names],
             "provenance": {"tool": "piezoloop", "start_ns": 5, "replay": recipe}}
    rows = [[k * 1e-3, 0.1 * k, 0.2, 0.0, state, 0, 0, k, 0, 0, 0, k == 4, 0, 0, 0, 0, 0]
            for k, state in enumerate([1, 2, 2, 2, 3, 2, 4, 5])]
    block = "\n".join(" ".join(f"{value:g}" for value in row) for row in rows)
    return json.dumps(about) + "\x1e" + block + "\x1e" + block

def texts() -> None:
    for name, text in TEXTS.items():
        into("log-text", name, text)
    into("log-text", "wide.csv", TEXTS["semicolons.csv"].encode("utf-16"))
    into("log-text", "latin.csv", TEXTS["semicolons.csv"].encode("latin-1"))
    into("estimate-options", "all.txt", TUNE)
    for target, ending, all_of in [("dataset", "toml", DATASETS), ("osp-system", "xml", OSPS), ("sweep-plan", "toml", SWEEPS),
                                   ("driver", "txt", DRIVERS)]:
        for name, text in all_of.items():
            into(target, f"{name}.{ending}", text)
    for target, lines in LINES.items():
        for name, (address, answers) in lines.items():
            into(target, f"{name}.txt", (address + "\n" + "\x1e".join(answers)).encode("latin-1"))
    into("bench-record", "direct.txt", journal())


def sources(work: Path) -> None:
    """FMUs of C sources, whose files are cut off."""
    for version in ["2", "3"]:
        fmu = work / f"sources{version}.fmu"
        subprocess.run([tool, "pack", root / "tests/blueprints/gain.toml", "--fmi", version, "--sources=only", "-o", fmu],
                       check=True, capture_output=True)
        with zipfile.ZipFile(fmu) as archive:
            wanted = [name for name in archive.namelist() if name.startswith("sources/") and not name.endswith("/")]
            entries = {name: archive.read(name)[:260] for name in ["modelDescription.xml", *wanted]}
            entries["modelDescription.xml"] = archive.read("modelDescription.xml")
        into("fmu-sources", f"gain{version}.fmu", stored(entries, work / "d.zip"))


def logs(work: Path) -> None:
    rows = 12
    time = np.arange(rows) / 2000.0
    u, counts = 5.0 * np.sin(time * 60.0), np.arange(rows, dtype=np.int16) * 3 - 700
    into("log-csv", "plain.csv", "time,u [V],y [um],counts\n" +
         "".join(f"{t!r},{a!r},{a / 10!r},{c}\n" for t, a, c in zip(time.tolist(), u.tolist(), counts.tolist())))
    into("log-csv", "records.csv", "time [ms],record,u[1] [V],note\r\n0,1,1.5,a\r\n1,1,2.5,b\r\n0,2,1e-3,c\r\n1,2,,d\r\n")
    into("log-csv", "quoted.csv", '"time","y, um"\n0,"1"\n0.1,"2"\n')
    savemat(work / "a.mat", {"time": time, "u": u, "counts": counts, "rate": 2000.0})
    into("log-mat", "plain.mat", (work / "a.mat").read_bytes())
    savemat(work / "a.mat", {"time": time, "u": u}, do_compression=True)
    into("log-mat", "packed.mat", (work / "a.mat").read_bytes())
    savemat(work / "a.mat", {"log": {"time": time}, "m": np.ones((4, 3))})
    into("log-mat", "structure.mat", (work / "a.mat").read_bytes())
    signals = np.zeros((1, 2), dtype=[("values", object), ("label", object)])
    signals[0, 0], signals[0, 1] = (np.ones((rows, 2)), "pos"), (u[:, None], "u")
    savemat(work / "a.mat", {"out": {"time": time[:, None], "signals": signals}, "tout": time})
    into("log-mat", "with_time.mat", (work / "a.mat").read_bytes())
    savemat(work / "a.mat", {"t": time, "u": u, "note": "text"}, format="4")
    into("log-mat4", "plain.mat", (work / "a.mat").read_bytes())
    into("log-mat4", "result.mat", dymola(time, u))
    for name, layout in ("plain", {}), ("packed", {"chunks": (1, 5), "compression": "gzip", "shuffle": True}):
        with h5py.File(work / "a.h5", "w", userblock_size=512) as file:
            file.create_dataset("t", data=time[None], **layout).attrs["MATLAB_class"] = np.bytes_("double")
            group = file.create_group("log")
            group.create_dataset("u", data=u[None], **layout)
            group.create_dataset("cell", (1, 1), dtype=h5py.ref_dtype)[0, 0] = file["t"].ref
        content = bytearray((work / "a.h5").read_bytes())
        content[:128] = b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM"
        into("log-hdf5", f"{name}.mat", bytes(content))
    with h5py.File(work / "a.h5", "w", libver="latest") as file:
        fields = np.zeros(rows, dtype=[("time", "<f8"), ("n", ">i2")])
        fields["time"] = time
        file.create_dataset("log", data=fields, chunks=(5,), maxshape=(None,), compression="gzip")
    into("log-hdf5", "latest.mat", (work / "a.h5").read_bytes())
    np.savez(work / "a.npz", time=time, u=u, counts=counts)
    with zipfile.ZipFile(work / "a.npz") as archive:
        arrays = {name: archive.read(name) for name in archive.namelist()}
    into("log-npz", "plain.npz", stored(arrays, work / "c.zip"))
    np.savez_compressed(work / "b.npz", time=time, u=u)
    into("log-npz", "packed.npz", (work / "b.npz").read_bytes())
    table = np.empty(rows, dtype=[("time", "<f8"), ("u", ">f8"), ("counts", "<i2")])
    table["time"], table["u"], table["counts"] = time, u, counts
    np.save(work / "a.npy", table)
    into("log-npy", "fields.npy", (work / "a.npy").read_bytes())
    np.save(work / "a.npy", np.ones((4, 3)))
    into("log-npy", "plain.npy", (work / "a.npy").read_bytes())
    # Bias and widths, then weight and centre of two support vectors.
    rows = np.array([[0.1, 1.0, 1.5, 2.0], [0.9, 1.0, 0.9, 0.8], [-0.3, 0.1, 0.2, 0.1]])
    tables = {"rows": rows, "columns": np.asfortranarray(rows), "single": rows.astype("f4"), "huge": rows * 1e300}
    tables |= {"two": rows[:, :3], "four": np.hstack([rows, rows[:, 3:]])}
    for name, values in tables.items():
        np.save(work / "a.npy", values)
        into("learned-table", f"{name}.npy", (work / "a.npy").read_bytes())
    frame = pd.DataFrame({"time": time, "u": u, "counts": counts})
    for compression in ["snappy", "zstd", "none"]:
        frame.to_parquet(work / "a.parquet", compression=compression, row_group_size=5, index=False)
        into("log-parquet", f"{compression}.parquet", (work / "a.parquet").read_bytes())
    with MDF(version="4.10") as mdf:
        mdf.append([Signal(u, time, unit="V", name="u"), Signal(counts, time, name="counts")], comment="fast")
        mdf.save(work / "a.mf4", compression=0, overwrite=True)
        into("log-mf4", "plain.mf4", (work / "a.mf4").read_bytes())
        words = {"val_0": 0, "text_0": b"off", "default": b"on"}
        mdf.append([Signal(counts, time, name="state", conversion=words),
                    Signal(counts, time, name="squared", conversion={"formula": "X1*X1-1"})])
        mdf.save(work / "b.mf4", compression=2, overwrite=True)
        into("log-mf4", "packed.mf4", (work / "b.mf4").read_bytes())
    with TdmsWriter(work / "a.tdms") as writer:
        group = GroupObject("fast")
        channels = [ChannelObject("fast", name, values, properties={"unit_string": unit})
                    for name, values, unit in [("time", time, "s"), ("u", u, "V")]]
        writer.write_segment([RootObject(), group, *channels])
        writer.write_segment(channels)
    into("log-tdms", "plain.tdms", (work / "a.tdms").read_bytes())
    raw = counts.tobytes()
    into("log-tdms", "interleaved.tdms", tdms(0x20, struct.pack("<IIIQ", 20, 2, 1, 1), raw))
    scaler = struct.pack("<IIIQI5I2I", 0x1269, 0xffffffff, 1, rows // 2, 1, 3, 0, 2, 0, 0, 1, 4)
    into("log-tdms", "daqmx.tdms", tdms(0x80, scaler, raw))


with tempfile.TemporaryDirectory() as folder:
    blueprints()
    systems(Path(folder))
    logs(Path(folder))
    descriptions(Path(folder))
    texts()
    sources(Path(folder))
    for path in sorted(gap.glob("*.json")):
        into("gap-json", path.name, path.read_bytes())

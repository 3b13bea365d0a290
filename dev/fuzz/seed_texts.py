"""The texts among the inputs that mutations start from: systems, logs, plans, and what instruments answer."""

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

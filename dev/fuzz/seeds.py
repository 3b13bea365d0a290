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

from seed_texts import DATASETS, DRIVERS, LINES, OSPS, SSD, SSM, SSV, SWEEPS, TEXTS, TUNE

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

"""Writes one log in every format that the tool reads, by the tools that users have."""

import sys
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from asammdf import MDF, Signal
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from scipy.io import savemat

folder = Path(sys.argv[1])
rows, rate = 1000, 2000.0
time = np.arange(rows) / rate
u = 5.0 * np.sin(2 * np.pi * 10.0 * time)
counts = np.arange(rows, dtype=np.int16) * 3 - 700
y = 0.1 * u + 0.01 * np.cos(time * 333.0)

with open(folder / "reference.csv", "w") as out:
    out.write("time,u [V],y [um],counts\n")
    for row in zip(time, u, y, counts):
        out.write(",".join(repr(v.item()) for v in row) + "\n")

# Nanoseconds since 1970, in which doubles have 256 ns, and a second group that begins 3 us later.
ticks = 1_700_000_000_000_000_000 + 1000 * np.arange(rows, dtype=np.int64)
np.savez(folder / "long.npz", time_ns=ticks, u=u, count=ticks)
pq.write_table(pa.table({"time_ns": ticks, "u": u, "count": ticks}), folder / "long.parquet")
np.savez(folder / "long_groups.npz", time_ns=ticks, u=u, t_ns=ticks[3:503:2], y=y[3:503:2])
dates = ticks.view("datetime64[ns]")
np.savez(folder / "date_groups.npz", time=dates, u=u, timestamps=dates[3:503:2], y=y[3:503:2])

savemat(folder / "plain.mat", {"time": time, "u": u, "y": y, "counts": counts, "rate": rate})
savemat(folder / "packed.mat", {"time": time, "u": u, "y": y, "counts": counts},
        do_compression=True)
savemat(folder / "structure.mat", {"log": {"time": time, "u": u, "y": y, "counts": counts}})
savemat(folder / "version4.mat", {"time": time, "u": u, "y": y, "counts": counts}, format="4")
savemat(folder / "rows.mat", {"t": time[None], "u": u[None], "y": y[None], "counts": counts[None]})
savemat(folder / "cells.mat", {"log": np.array([{"u": u}, {"u": y}], dtype=object)})
matrix = np.stack([u, y, counts], axis=1)
savemat(folder / "simulink.mat", {"tout": time[:, None], "yout": matrix})
savemat(folder / "to_file.mat", {"ans": np.vstack([time, matrix.T])})
signals = np.zeros((1, 2), dtype=[("values", object), ("label", object), ("dimensions", object)])
signals[0, 0] = (np.stack([u, y], axis=1), "pos", 2.0)
signals[0, 1] = (counts[:, None].astype(float), "counts", 1.0)
logged = {"time": time[:, None], "signals": signals, "blockName": "m/Scope"}
savemat(folder / "with_time.mat", {"out": logged}, do_compression=True)


def version_7_3(name, chunked):
    """As MATLAB does: sizes reversed, the class an attribute, elements of arrays in #refs#."""
    layout = {"chunks": (1, 300), "compression": "gzip", "shuffle": True} if chunked else {}
    with h5py.File(folder / name, "w", userblock_size=512) as file:
        def put(where, key, values, **options):
            values = np.atleast_2d(values)
            dataset = where.create_dataset(key, data=values, **options)
            kind = {"float64": "double"}.get(values.dtype.name, values.dtype.name)
            dataset.attrs["MATLAB_class"] = np.bytes_(kind)
            return dataset

        put(file, "tout", time, **layout)
        put(file, "yout", matrix.T, **layout)
        text = file.create_dataset("note", data=np.array([[ord(c)] for c in "a note"], np.uint16))
        text.attrs["MATLAB_class"] = np.bytes_("char")
        out = file.create_group("out")
        out.attrs["MATLAB_class"] = np.bytes_("struct")
        put(out, "time", time, **layout)
        inner = out.create_group("signals")
        inner.attrs["MATLAB_class"] = np.bytes_("struct")
        refs = file.create_group("#refs#")
        for field, values in (("values", (u, y)), ("label", ("position", "force"))):
            places = inner.create_dataset(field, (2, 1), dtype=h5py.ref_dtype)
            for at, value in enumerate(values):
                if field == "label":
                    value = np.array([[ord(c)] for c in value], np.uint16)
                element = put(refs, f"{field}{at}", value)
                if field == "label":
                    element.attrs["MATLAB_class"] = np.bytes_("char")
                places[at, 0] = element.ref
    with open(folder / name, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\0\2IM")


version_7_3("plain73.mat", False)
version_7_3("packed73.mat", True)
with h5py.File(folder / "plain.h5", "w", libver="latest") as file:
    for name, values, unit in (("time", time, "s"), ("u", u, "V"), ("y", y, "um"), ("counts", counts, "")):
        dataset = file.create_dataset(name, data=values, chunks=(128,), maxshape=(None,), compression="gzip")
        dataset.attrs["units"] = unit
with h5py.File(folder / "octave.h5", "w") as file:
    for name, values in (("time", time), ("u", u), ("y", y), ("counts", counts)):
        variable = file.create_group(name)
        variable.attrs["OCTAVE_NEW_FORMAT"] = np.uint8(1)
        variable.create_dataset("type", data=np.bytes_("matrix"))
        variable.create_dataset("value", data=values[None])
with h5py.File(folder / "fields.h5", "w") as file:
    fields = np.empty(rows, dtype=[("time", "<f8"), ("u", ">f8"), ("y", "<f8"), ("counts", "<i2")])
    fields["time"], fields["u"], fields["y"], fields["counts"] = time, u, y, counts
    file.create_group("run").create_dataset("log", data=fields)
# Complex numbers: a frequency response, with its frequencies.
frequency, response = 4.0 * np.arange(1, 51), 2.0 / (1 + 1j * np.arange(1, 51) / 10)
savemat(folder / "complex.mat", {"f": frequency, "G": response[None, None]})
savemat(folder / "complex4.mat", {"f": frequency, "G": response}, format="4")
np.savez(folder / "complex.npz", f=frequency, G=response)
with h5py.File(folder / "complex.h5", "w") as file:
    file["f"], file["G"] = frequency, response
savemat(folder / "lengths.mat", {"time": time, "u": u, "slow": u[::10]})
np.savez(folder / "plain.npz", time=time, u=u, y=y, counts=counts)
np.savez_compressed(folder / "packed.npz", time=time, u=u, y=y, counts=counts)
table = np.empty(rows, dtype=[("time", "<f8"), ("u", ">f8"), ("y", "<f8"), ("counts", "<i2")])
table["time"], table["u"], table["y"], table["counts"] = time, u, y, counts
np.save(folder / "fields.npy", table)
np.save(folder / "cut.npy", table)
(folder / "cut.npy").write_bytes((folder / "cut.npy").read_bytes()[:5000])
np.save(folder / "objects.npy", np.array([{}, {}], dtype=object))

frame = pd.DataFrame({"time": time, "u": u, "y": y, "counts": counts})
for compression in ["snappy", "gzip", "zstd", "none"]:
    frame.to_parquet(folder / f"{compression}.parquet", compression=compression,
                     row_group_size=300)
fields = pa.Table.from_pandas(frame, preserve_index=False)
fields = fields.replace_schema_metadata({"unit:u": "V", "unit:y": "um"})
pq.write_table(fields, folder / "units.parquet")
dated = frame[["u", "y"]].set_index(pd.Timestamp("2026-03-01 12:00:00.25") + pd.to_timedelta(time, "s"))
dated.to_parquet(folder / "dated.parquet")
frame.assign(time=pd.to_timedelta(time, "s")).to_parquet(folder / "durations.parquet")
spans = pa.Table.from_pandas(frame.assign(time=pd.to_timedelta(time, "s")), preserve_index=False)
pq.write_table(spans.replace_schema_metadata(None), folder / "arrow.parquet")
pq.write_table(pa.Table.from_pandas(dated.rename_axis("time").reset_index(), preserve_index=False),
               folder / "spark.parquet", use_deprecated_int96_timestamps=True)
pq.write_table(pa.table({"time": time, "half": pa.array(np.full(rows, 0.5, np.float16))}), folder / "half.parquet")
np.savez(folder / "dated.npz", time=np.datetime64("2026-03-01T12:00:00.250", "ns") + pd.to_timedelta(time, "s").to_numpy("m8[ns]"),
         u=u, y=y, half=np.full(rows, 0.5, np.float16), z=u + 1j, words=np.array(["a"] * rows))
frame.assign(big=np.full(rows, 2**32 - 5, np.uint32), small=np.full(rows, 250, np.uint8),
             huge=np.full(rows, 2**63, np.uint64)).to_parquet(folder / "unsigned.parquet")
frame.loc[5, "y"] = None
frame.to_parquet(folder / "gap.parquet")

with MDF(version="4.10") as mdf:
    signals = [Signal(u, time, unit="V", name="u"), Signal(y, time, unit="um", name="y"),
               Signal(counts, time, name="counts")]
    mdf.append(signals, comment="fast")
    mdf.save(folder / "plain.mf4", compression=0, overwrite=True)
    mdf.save(folder / "packed.mf4", compression=1, overwrite=True)
    mdf.save(folder / "transposed.mf4", compression=2, overwrite=True)
    mdf.append([Signal(u[::10], time[::10], unit="V", name="slow")])
    mdf.save(folder / "rates.mf4", compression=0, overwrite=True)
with MDF(version="4.10") as mdf:
    words = {"val_0": 0, "val_1": 1, "text_0": b"off", "text_1": b"on", "default": b"fault"}
    mdf.append([Signal(u, time, unit="V", name="u"), Signal(y, time, unit="um", name="y"),
                Signal((np.arange(rows) % 3).astype(np.uint8), time, name="state", conversion=words),
                Signal(np.arange(rows), time, unit="furlong", name="odd"),
                Signal(np.array([b"a", b"bc"] * (rows // 2)), time, name="text", encoding="utf-8"),
                Signal(counts, time, name="counts", conversion={"a": 2.0, "b": 1.0}),
                Signal(counts, time, name="squared", conversion={"formula": "X1*X1 - 1"})])
    mdf.save(folder / "words.mf4", compression=0, overwrite=True)
with MDF(version="3.30") as mdf:
    mdf.append([Signal(u, time, unit="V", name="u")])
    mdf.save(folder / "old.mdf", compression=0, overwrite=True)

with TdmsWriter(folder / "plain.tdms") as writer:
    def channel(name, data, unit=None):
        properties = {"wf_increment": 1 / rate, "wf_start_offset": 0.0}
        if unit:
            properties["unit_string"] = unit
        return ChannelObject("scope", name, data, properties=properties)

    # Two segments, as a recorder writes them.
    for half in (slice(0, 400), slice(400, None)):
        writer.write_segment([RootObject(), GroupObject("scope"),
                              channel("u", u[half], "V"), channel("y", y[half], "um"),
                              channel("counts", counts[half])])


def waveforms(name, *channels):
    """One group of channels: name, values and waveform properties each."""
    start = np.datetime64("2026-03-01T12:00:00.000000", "us")
    with TdmsWriter(folder / name) as writer:
        writer.write_segment([RootObject(), GroupObject("run")] + [
            ChannelObject("run", channel, values, properties={
                "wf_increment": increment, "wf_start_offset": offset,
                "wf_start_time": start + np.timedelta64(int(later * 1e6), "us")})
            for channel, values, increment, offset, later in channels])


waveforms("alike.tdms", ("u", u, 1 / rate, 0.25, 3.0), ("y", y, 1 / rate, 0.25, 3.0))
waveforms("starts.tdms", ("u", u, 1 / rate, 0.0, 0.0), ("y", y, 1 / rate, 0.0, 3.0))
waveforms("offsets.tdms", ("u", u, 1 / rate, 0.0, 0.0), ("y", y, 1 / rate, 0.05, 0.0))
waveforms("increments.tdms", ("u", u, 1 / rate, 0.0, 0.0), ("y", y, 2 / rate, 0.0, 0.0))
waveforms("lengths.tdms", ("u", u, 1 / rate, 0.0, 0.0), ("y", y[::2], 2 / rate, 0.0, 0.0))

with TdmsWriter(folder / "tests.tdms") as writer:
    # Two tests one after the other, with channels of other names.
    noon = np.datetime64("2026-03-01T12:00:00.000000", "us")
    writer.write_segment([RootObject()] + [
        ChannelObject(group, channel, values, properties={
            "wf_increment": 1 / rate, "wf_start_offset": 0.0,
            "wf_start_time": noon + np.timedelta64(later, "us")})
        for group, channel, values, later in (
            ("first", "u", u, 0), ("first", "y", y, 0),
            ("second", "v", u, 60_250_000), ("second", "w", y, 60_250_000))])

np.save(folder / "transposed.npy", np.vstack([np.tile(time, 2), np.tile(u, 2)]))

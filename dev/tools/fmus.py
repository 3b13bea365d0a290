"""Packs, checks and tries the FMUs of all rigs; called by dev/tools/fmus."""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from fmpy import extract, read_model_description

libraries, tools, out = map(Path, sys.argv[1:])
tool = libraries / "piezoloop"


def piezoloop(*arguments):
    command = [tool, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}: {done.stdout}{done.stderr}")
    return done.stdout


def hosts():
    """For each platform: how tests/c/run.c is started there, and the prefix of a path."""
    found = {"linux64": ([tools / "run"], "")}
    qemu, wine = shutil.which("qemu-aarch64"), shutil.which("wine64")
    wine = wine or (w if Path(w := "/usr/lib/wine/wine64").exists() else None)
    if qemu and Path("/usr/aarch64-linux-gnu").is_dir():
        found["aarch64-linux"] = ([qemu, "-L", "/usr/aarch64-linux-gnu", tools / "run-aarch64"], "")
    if wine:
        found["win64"] = ([wine, tools / "run.exe"], "/Z:")
    for platform in list(found):
        if not Path(found[platform][0][-1]).exists():
            del found[platform]
    return found


def tried(fmu, there):
    """Runs the FMU of FMI 2.0 on every platform; all must compute the same bits."""
    folder = Path(extract(str(fmu)))
    model = read_model_description(str(fmu))

    def of(causality):
        wanted = (v for v in model.modelVariables if v.causality == causality and v.type == "Real")
        return ",".join(str(v.valueReference) for v in wanted)

    said = {}
    for platform, (host, prefix) in there.items():
        (library,) = (folder / "binaries" / platform).iterdir()
        uri = f"file://{prefix}{folder}/resources"
        step = str(model.defaultExperiment.stepSize)
        command = [*host, library, model.guid, uri, step, of("input"), of("output")]
        environment = {"WINEDEBUG": "-all", "WINEPREFIX": str(tools / "wine"), "PATH": "/usr/bin:/bin"}
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, env=environment)
        said[platform] = done.stdout.replace("\r", "")
        if done.returncode:
            sys.exit(f"{fmu.name} on {platform}: {done.stdout}{done.stderr}")
    if len(set(said.values())) > 1:
        sys.exit(f"{fmu.name}: platforms compute other bits: {said}")
    shutil.rmtree(folder)


there = hosts()
for platform in ("linux64", "aarch64-linux", "win64"):
    if not (libraries / platform).is_dir():
        print(f"SKIPPED: {platform}: dev/tools/portable has not built it")
    elif platform not in there:
        print(f"SKIPPED: {platform} is not tried: its runner is not installed here")
with tempfile.TemporaryDirectory() as scratch:
    tempfile.tempdir = scratch
    for rig in json.loads(piezoloop("list", "rigs", "--json")):
        for version in (3, 2):
            fmu = out / f"{rig['name']}-fmi{version}.fmu"
            options = ["--fmi", version, "--libraries", libraries, "-o", fmu, "--json"]
            packed = json.loads(piezoloop("pack", rig["name"], *options))
            piezoloop("check", fmu)
        tried(fmu, there)
        size = fmu.stat().st_size / 1e6
        print(f"{rig['name']}: for {', '.join(packed['platforms'])}; no problem; {size:.1f} MB; ", end="")
        print(f"runs with the same bits on {', '.join(there)}", flush=True)

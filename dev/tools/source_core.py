"""From what wasm2c wrote to the one file that source-code FMUs carry: crates/source/c/core.h.gz.

Everything becomes static, so that several FMUs link into one program; functions that nothing calls and that
would need a mathematical library are left out; so are reads whose result nobody uses. Writes are checked against the
bounds of the memory. Addresses of reads are masked instead: a wild one reads another place of its own instance.
"""
import gzip, hashlib, pathlib, re, sys

build, rust, wabt, *options = sys.argv[1:]
build, folder = pathlib.Path(build), pathlib.Path("crates/source/c")
header, code = (build / "core.h").read_text(), (build / "core.c").read_text()


def cut(text, start, end):
    """Without the part from `start` up to `end`, each of which must be there."""
    first = text.index(start)
    return text[:first] + text[text.index(end, first):]


header = cut(header, "#include \"wasm-rt.h\"", "#ifndef WASM_RT_CORE_TYPES_DEFINED")
header = cut(header, "#ifdef __cplusplus", "struct w2c_host;")
header = cut(header, "wasm_rt_func_type_t wasm2c_core_get_func_type", "/* import")
header = header[:header.index("#ifdef __cplusplus")] + "#endif\n"
header = re.sub(r"^(\w[\w ]*\*? (?:wasm2c|w2c)_\w+\(.*\);)$", r"static \1", header, flags=re.M)
code = code[code.index("#define IS_SINGLE_UNSHARED_MEMORY"):]
first = code.index("wasm_rt_func_type_t wasm2c_core_get_func_type")
end = code.index("\n}\n", first) + 3
code = code[:first] + code[end:]
for start, end in [("static double wasm_floor(", "static float wasm_fabsf("), ("static double wasm_sqrt(", "static inline void memory_fill(")]:
    names = re.findall(r"(wasm_\w+)\(", code[code.index(start):code.index(end)])
    code = cut(code, start, end)
    assert not any(re.search(rf"\b{name}\(", code) for name in names), f"the core calls one of {names}"
code = re.sub(r"#ifdef __GNUC__\n(#define FORCE_READ_INT)", r"#if 0\n\1", code)
reads = code[code.index("#define DEF_MEM_CHECKS0("):code.index("#define DEF_MEM_CHECKS1(")]
masked = re.sub(r"^ +MEMCHECK_DEFAULT32\(.*\\\n", r"    addr &= MASK(mem); \\\n", reads, flags=re.M)
assert masked != reads, "wasm2c writes the checks of reads in another way"
code = code.replace(reads, masked)
code, found = re.subn(r"(#define DEFINE_LOAD\(.*\n.*\n)    t1 result; +\\\n    wasm_rt_memcpy\(&result, (.*), +\\\n +sizeof\(t1\)\);", r"\1    t1 result; READ_CELL(result, \2, t1);", code)
assert found == 1, "wasm2c writes reads in another way"
code, found = re.subn(r"    wasm_rt_memcpy\((MEM_ADDR_MEMOP\(mem, addr, sizeof\(t1\)\)), &wrapped, +\\\n +sizeof\(t1\)\);", r"    WRITE_CELL(\1, wrapped, t1);", code)
assert found == 1, "wasm2c writes writes in another way"
code, found = re.subn(r"(a \+ \(uint64_t\)sizeof\(t\) > )mem->size", r"\1LIMIT(mem)", code)
assert found == 1, "wasm2c writes the checks in another way"
text = f"/* Piezoloop's core: Rust {rust}, translated by wasm2c of wabt {wabt}. Nobody writes it by hand. */\n" + header + code
packed = gzip.compress(text.encode(), 9, mtime=0)
digest = hashlib.sha256(text.encode()).hexdigest()
record = f"rust {rust}\nwabt {wabt}\nsha256 {digest}\nbytes {len(text)}\nlines {text.count(chr(10))}\n"
if "--check" in options:
    found = hashlib.sha256(gzip.decompress((folder / "core.h.gz").read_bytes())).hexdigest()
    if found != digest:
        sys.exit(f"crates/source/c/core.h.gz is not what the sources give: sha256 {found}, made anew {digest}; run dev/tools/source-core")
    print(f"crates/source/c/core.h.gz is what the sources give: sha256 {digest}")
else:
    (folder / "core.h.gz").write_bytes(packed)
    (folder / "core.txt").write_text(record)
    print(record, f"packed {len(packed)}", sep="")

//! Makes the library call its own functions, whatever the host exports under the same names, and
//! export those of the standard alone.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let target = |key| std::env::var(key).unwrap_or_default();
    if target("CARGO_CFG_TARGET_OS") == "linux" {
        // In a host that exports `fmi2DoStep`, or loads with RTLD_GLOBAL, a call by name would
        // otherwise reach somebody else's.
        println!("cargo:rustc-cdylib-link-arg=-Wl,-Bsymbolic");
    }
    if target("CARGO_CFG_TARGET_OS") == "linux"
        && target("CARGO_CFG_TARGET_ENV") == "gnu"
        && target("CARGO_CFG_TARGET_ARCH") == "x86_64"
        && !links_with_zig()
    {
        // Where the functions of the loader are until glibc 2.34, and an empty library afterwards; nothing that
        // is linked here needs it by name, so it is named by its file.
        println!(
            "cargo:rustc-cdylib-link-arg=-Wl,--push-state,--no-as-needed,-l:libdl.so.2,--pop-state"
        );
    }
    if target("CARGO_CFG_TARGET_OS") == "windows" && target("CARGO_CFG_TARGET_ENV") == "gnu" {
        // zig as linker is not given rustc's list of exports, and without one exports everything.
        let list = concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/fmi-bindings/fmi.def");
        println!("cargo:rerun-if-changed={list}");
        println!("cargo:rustc-cdylib-link-arg={list}");
    }
}

/// zig links against the C library of an old glibc, in which the functions of the loader are in libdl already, and does
/// not know the options that keep a library.
fn links_with_zig() -> bool {
    println!("cargo:rerun-if-env-changed=RUSTC_LINKER");
    std::env::var("RUSTC_LINKER").is_ok_and(|linker| linker.contains("zig"))
}

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
    if target("CARGO_CFG_TARGET_OS") == "windows" && target("CARGO_CFG_TARGET_ENV") == "gnu" {
        // zig as linker is not given rustc's list of exports, and without one exports everything.
        let list = concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/fmi-bindings/fmi.def");
        println!("cargo:rerun-if-changed={list}");
        println!("cargo:rustc-cdylib-link-arg={list}");
    }
}

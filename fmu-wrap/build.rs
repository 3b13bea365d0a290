//! Makes the library call its own functions, whatever the host exports under the same names.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let os = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    if os == "linux" {
        // In a host that exports `fmi2DoStep`, or loads with RTLD_GLOBAL, a call by name would
        // otherwise reach somebody else's.
        println!("cargo:rustc-cdylib-link-arg=-Wl,-Bsymbolic");
    }
}

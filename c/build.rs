//! Names the C library.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // Without a name a program that is linked with a path of the library would need it in that place. The number of the interface is
    // not in the name: cargo makes no file of such a name, and a program compares `inbye_abi_version`.
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libinbye_c.so");
    }
}

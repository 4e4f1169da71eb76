//! Gives the shared library the name by which programs ask for it, whatever path they were linked
//! by.

fn main() {
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libtaut.so");
    println!("cargo::rerun-if-changed=build.rs");
}

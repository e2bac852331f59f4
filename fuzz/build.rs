//! Builds and links `trace.c`, which counts the coverage of libhdf5 for libFuzzer.
//!
//! gcc compiles libhdf5 and has no counters of libFuzzer's kind. But it can call a function at
//! every edge of the control flow.

fn main() {
    println!("cargo::rerun-if-changed=trace.c");
    cc::Build::new()
        .file("trace.c")
        .no_default_flags(true)
        .flag("-O2")
        .flag("-fPIC")
        .cargo_metadata(false)
        .compile("trace");
    let folder = std::env::var("OUT_DIR").expect("cargo sets it");
    println!("cargo::rustc-link-search=native={folder}");
    println!("cargo::rustc-link-lib=static:+whole-archive=trace");
    println!("cargo::rustc-link-arg-bins=-Wl,--wrap=__sanitizer_cov_trace_pc");
}

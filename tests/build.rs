//! Four switches for the tests of this package, so that a test that cannot run shows as ignored, with its reason:
//! `crowd_assets` where real characters are at hand, `crowd_no_gpu` where the run opted out of GPU tests aloud,
//! `crowd_no_display` where the run opted out of windows aloud or there is no Xvfb to open one in,
//! `crowd_no_shim` where no library can be made that stands in for Vulkan's.

use std::path::Path;

fn main() {
    println!("cargo::rustc-check-cfg=cfg(crowd_assets)");
    println!("cargo::rustc-check-cfg=cfg(crowd_no_gpu)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=CROWD_ASSETS");
    println!("cargo::rerun-if-env-changed=CROWD_NO_GPU");

    let beside_the_repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/assets");
    println!("cargo::rerun-if-changed={}", beside_the_repository.display());
    let named = std::env::var_os("CROWD_ASSETS").filter(|v| !v.is_empty());
    if named.is_some_and(|folder| Path::new(&folder).is_dir()) || beside_the_repository.is_dir() {
        println!("cargo::rustc-cfg=crowd_assets");
    }
    println!("cargo::rustc-check-cfg=cfg(crowd_no_display)");
    println!("cargo::rerun-if-env-changed=CROWD_NO_DISPLAY");
    println!("cargo::rerun-if-env-changed=PATH");
    let path = std::env::var_os("PATH").unwrap_or_default();
    let server = std::env::split_paths(&path).map(|folder| folder.join("Xvfb")).find(|file| file.is_file());
    match server.filter(|_| std::env::var_os("CROWD_NO_DISPLAY").is_none_or(|v| v != "1")) {
        // An Xvfb that goes is noticed by its file; one that comes, by the switch, which tests/run.sh sets as long as there is none.
        Some(file) => println!("cargo::rerun-if-changed={}", file.display()),
        None => println!("cargo::rustc-cfg=crowd_no_display"),
    }
    println!("cargo::rustc-check-cfg=cfg(crowd_no_shim)");
    let has_compiler = std::env::split_paths(&path).any(|folder| folder.join("cc").is_file());
    if !has_compiler || !cfg!(target_os = "linux") {
        println!("cargo::rustc-cfg=crowd_no_shim");
    }
    if std::env::var_os("CROWD_NO_GPU").is_some_and(|v| v == "1") {
        println!("cargo::rustc-cfg=crowd_no_gpu");
    }
}

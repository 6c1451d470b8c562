//! Tells the program where it finds Open Image Denoise at run time: where the build found it.

fn main() {
    println!("cargo:rerun-if-env-changed=OIDN_DIR");
    let is_wanted = std::env::var_os("CARGO_FEATURE_OIDN").is_some();
    let has_rpath = std::env::var_os("CARGO_CFG_UNIX").is_some();
    if let Ok(folder) = std::env::var("OIDN_DIR")
        && is_wanted
        && has_rpath
        && !folder.is_empty()
    {
        println!("cargo:rustc-link-arg=-Wl,-rpath,{folder}/lib");
    }
}

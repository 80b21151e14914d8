//! Says when the embedded page is another one. Never builds it.

use std::path::Path;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // A folder that is missing would count as changed every time.
    if Path::new("ui/dist").is_dir() {
        println!("cargo:rerun-if-changed=ui/dist");
    }
}

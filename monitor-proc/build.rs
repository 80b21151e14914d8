//! Reports changes of the embedded page. Never builds it.

use std::path::Path;

/// Set by release builds: without the page they fail.
const ENV_EMBED_PAGE: &str = "ROBOCELL_EMBED_PAGE";

fn main() -> Result<(), String> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed={ENV_EMBED_PAGE}");
    // A missing folder would count as changed every time.
    if Path::new("ui/dist").is_dir() {
        println!("cargo:rerun-if-changed=ui/dist");
    }
    let wanted = std::env::var_os(ENV_EMBED_PAGE).is_some_and(|value| value != "0");
    if wanted && !Path::new("ui/dist/index.html").is_file() {
        return Err(format!(
            "{ENV_EMBED_PAGE} is set and monitor-proc/ui/dist holds no page; build it with `npm ci \
             && npm run build` in monitor-proc/ui"
        ));
    }
    Ok(())
}

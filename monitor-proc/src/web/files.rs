//! The built page: read once, into memory. Files that are not in the list do not exist, so a
//! path of a request cannot lead elsewhere.

use std::collections::BTreeMap;
use std::path::Path;

use axum::body::Bytes;
use rust_embed::RustEmbed;

/// Largest number of files and bytes served: they are kept in memory.
const MAX_FILES: usize = 4000;
const MAX_BYTES: u64 = 128 << 20;
/// Levels of folders.
// A link that leads back must not be followed for ever.
const MAX_DEPTH: usize = 8;

/// The page of a release.
#[derive(RustEmbed)]
#[folder = "ui/dist"]
#[allow_missing = true]
struct Embedded;

/// One file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asset {
    /// Its bytes.
    pub body: Bytes,
    /// Its type for browsers.
    pub mime: &'static str,
}

/// Whether this program holds a page.
pub fn has_page() -> bool {
    Embedded::get("index.html").is_some()
}

/// Files by the path of their request, `/index.html`.
#[derive(Clone, Debug, Default)]
pub struct Files {
    by_path: BTreeMap<String, Asset>,
    /// Files beyond a limit, which are not served.
    left_out: usize,
}

impl Files {
    /// The built page in `dist`, or the embedded one. None if the launcher gives a `hint` why
    /// it could not build the page: the embedded one may be outdated.
    pub fn page(dist: Option<&Path>, hint: &str) -> Self {
        match dist {
            Some(dist) => Self::folder(dist, ""),
            None if hint.is_empty() => Self::embedded(),
            None => Self::default(),
        }
    }

    /// All files under `folder`, with `prefix` before their paths. Links are not followed;
    /// unreadable files are left out.
    pub fn folder(folder: &Path, prefix: &str) -> Self {
        let mut files = Self::default();
        let mut room = MAX_BYTES;
        files.walk(folder, prefix, MAX_DEPTH, &mut room);
        files
    }

    fn embedded() -> Self {
        let mut files = Self::default();
        for path in Embedded::iter() {
            if let Some(file) = Embedded::get(&path) {
                files.insert(format!("/{path}"), file.data.into_owned());
            }
        }
        files
    }

    fn walk(&mut self, folder: &Path, prefix: &str, depth: usize, room: &mut u64) {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        for entry in entries {
            // A name that is not UTF-8 cannot be requested by a browser.
            let (Ok(kind), Ok(name)) = (entry.file_type(), entry.file_name().into_string()) else {
                continue;
            };
            let path = format!("{prefix}/{name}");
            if kind.is_dir() && depth > 0 {
                self.walk(&entry.path(), &path, depth - 1, room);
                continue;
            }
            let size = entry.metadata().map_or(u64::MAX, |meta| meta.len());
            // Counted, so that the log tells why a mesh is missing.
            if kind.is_dir() || size > *room || self.by_path.len() >= MAX_FILES {
                self.left_out += 1;
                continue;
            }
            if !kind.is_file() {
                continue;
            }
            if let Ok(body) = std::fs::read(entry.path()) {
                *room -= size.min(*room);
                self.insert(path, body);
            }
        }
    }

    fn insert(&mut self, path: String, body: Vec<u8>) {
        let mime = mime(&path);
        let body = Bytes::from(body);
        self.by_path.insert(path, Asset { body, mime });
    }

    /// The file with exactly this path; `/` is the page itself.
    pub fn get(&self, path: &str) -> Option<&Asset> {
        self.by_path
            .get(if path == "/" { "/index.html" } else { path })
    }

    /// The gzip of the file at `path`, where the build of the page wrote one beside it.
    pub fn gzip_of(&self, path: &str) -> Option<&Asset> {
        let path = if path == "/" { "/index.html" } else { path };
        self.by_path.get(&format!("{path}.gz"))
    }

    /// A message with the number of files of `what` that are not served, if any.
    #[must_use]
    pub fn limit(&self, what: &str) -> Option<String> {
        (self.left_out > 0).then(|| {
            format!(
                "{} files of {what} are not served: at most {MAX_FILES} files with {} MiB in \
                 {MAX_DEPTH} folders deep are",
                self.left_out,
                MAX_BYTES >> 20
            )
        })
    }

    /// Whether there is a page.
    pub fn has_page(&self) -> bool {
        self.get("/").is_some()
    }

    /// The paths.
    pub fn paths(&self) -> impl Iterator<Item = &str> + Clone {
        self.by_path.keys().map(String::as_str)
    }
}

fn mime(path: &str) -> &'static str {
    match path.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" | "map" => "application/json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "wasm" => "application/wasm",
        "glb" => "model/gltf-binary",
        "txt" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

//! Answers with a file of the page: its type, how long browsers may keep it, and its gzip for
//! clients that read it.

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

use super::files::{Asset, Files};
use super::plain::line;

/// The file at `path`, compressed where there is a gzip of it that the client reads.
pub(super) fn of(files: &Files, path: &str, headers: &HeaderMap) -> Response {
    let response = plain(files.get(path), path);
    match files.gzip_of(path) {
        Some(packed) if accepts_gzip(headers) => gzipped(response, packed),
        _ => response,
    }
}

/// A file as it is.
pub(super) fn plain(asset: Option<&Asset>, path: &str) -> Response {
    let Some(asset) = asset else {
        return line(StatusCode::NOT_FOUND, "no such file\n");
    };
    // Names of built files have a hash of their content.
    let caching = if path.starts_with("/assets/") {
        "private, max-age=31536000, immutable"
    } else {
        "no-store"
    };
    let headers = [
        (header::CONTENT_TYPE, asset.mime),
        (header::CACHE_CONTROL, caching),
    ];
    (headers, Body::from(asset.body.clone())).into_response()
}

/// Whether the client reads gzip: any mention of it but a refusal, `gzip;q=0` (RFC 9110, 12.5.3).
fn accepts_gzip(headers: &HeaderMap) -> bool {
    let accepted = headers.get_all(header::ACCEPT_ENCODING).iter();
    accepted
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .any(|coding| {
            let (name, quality) = coding.split_once(';').unwrap_or((coding, ""));
            let weight = quality.trim().strip_prefix("q=");
            let is_refused = weight.is_some_and(|weight| weight.parse() == Ok(0.0));
            name.trim().eq_ignore_ascii_case("gzip") && !is_refused
        })
}

/// `plain` with the compressed body, and the type and caching of the plain one.
fn gzipped(plain: Response, packed: &Asset) -> Response {
    let (mut parts, _) = plain.into_parts();
    let encoding = HeaderValue::from_static("gzip");
    parts.headers.insert(header::CONTENT_ENCODING, encoding);
    let vary = HeaderValue::from_static("accept-encoding");
    parts.headers.insert(header::VARY, vary);
    Response::from_parts(parts, Body::from(packed.body.clone()))
}

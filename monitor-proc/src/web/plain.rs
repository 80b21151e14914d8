//! Pages in plain HTML, where the page itself is missing or refused.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

/// The page is not built.
pub(super) fn no_page(hint: &str) -> Response {
    let hint = if hint.is_empty() {
        "Install Node 20 or newer (https://nodejs.org, or the package `nodejs` of your \
         distribution), then start the cell again: the page is built once."
    } else {
        hint
    };
    let text = format!(
        "<h1>The cell runs; its page is not built</h1>\n<p id=\"hint\">{}</p>\n\
         <p>Everything else works: <code>robocell status</code>, <code>robocell top</code>, \
         <code>robocell help</code>.</p>",
        escape(hint)
    );
    page(StatusCode::OK, &text)
}

/// Page for a request without a token or cookie.
pub(super) fn no_cookie() -> Response {
    let text = "<h1>This page needs its token</h1>\n\
        <p>Open the link that <code>robocell status</code> prints, with \
        <code>?token=...</code> at its end. Each link opens the page in one browser.</p>\n\
        <p>If you have just done so, <a href=\"/\">open the page</a>.</p>";
    page(StatusCode::UNAUTHORIZED, text)
}

/// Page for a link that was opened before, without the cookie it was exchanged for.
pub(super) fn used_token() -> Response {
    let text = "<h1>This link was used already</h1>\n\
        <p>It opens the page in one browser; <code>robocell status</code> prints a new one.</p>";
    page(StatusCode::FORBIDDEN, text)
}

/// Page for a token of another run, or an invalid one.
pub(super) fn wrong_token() -> Response {
    let text = "<h1>This is not the token of this run</h1>\n\
        <p>Each run has its own; <code>robocell status</code> prints the link.</p>";
    page(StatusCode::FORBIDDEN, text)
}

/// One line of text.
pub(super) fn line(status: StatusCode, text: impl IntoResponse) -> Response {
    let mut response = (status, text).into_response();
    // A refusal must not be shown again from a cache after the person has got the token.
    no_store(&mut response);
    response
}

fn page(status: StatusCode, body: &str) -> Response {
    let text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>robocell</title>\n\
         <style>body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 40em; margin: 4em auto; \
         padding: 0 1em; color: #222; }} h1 {{ font-size: 1.4em; }}</style>\n{body}\n</html>\n"
    );
    let kind = [(header::CONTENT_TYPE, "text/html; charset=utf-8")];
    let mut response = (status, kind, text).into_response();
    no_store(&mut response);
    response
}

/// Keeps the answer out of caches.
pub(super) fn no_store(response: &mut Response) {
    let never = HeaderValue::from_static("no-store");
    response.headers_mut().insert(header::CACHE_CONTROL, never);
}

/// Escapes text for HTML.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_hint_is_text() {
        assert_eq!(
            super::escape("<b a=\"1\">&"),
            "&lt;b a=&quot;1&quot;&gt;&amp;"
        );
    }
}

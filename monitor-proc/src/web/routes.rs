//! Routes of the server and the order of their checks: the name of the server, then the role of
//! the sender, then the request.

use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::connect_info::ConnectInfo;
use axum::extract::rejection::{JsonRejection, PathRejection, QueryRejection};
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::{DefaultBodyLimit, Path, Query, Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{any, get, post};
use serde::Deserialize;

use super::access::Exchange;
use super::connection_limit::Idle;
use super::state::{AppState, Search};
use super::{edit, file_response, plain, socket};
use crate::timeline::scrub::PastSpan;

/// Largest body of a request (bytes).
// A token or a command; texts of policies have their own limit.
const MAX_BODY: usize = 4096;
/// Scripts, styles and connections of this server only; the page may create pictures itself.
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; \
    img-src 'self' data: blob:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; \
    form-action 'none'; object-src 'none'";

type Ours = State<Arc<AppState>>;

/// All routes behind the first check.
pub(super) fn router(state: Arc<AppState>) -> Router {
    Router::new()
        .route("/ws", any(websocket))
        .route("/api/scene", any(scene))
        .route("/api/incidents/{number}", any(incident))
        .route("/api/past", any(past))
        .route("/api/grasps/{arm}/{object}", any(grasps))
        .route("/api/joints/{arm}/{pose}", any(joints))
        .route(
            "/api/policy",
            get(edit::read)
                .post(edit::write)
                .layer(DefaultBodyLimit::max(edit::MAX_TEXT)),
        )
        .route("/api/token", post(token))
        .fallback(file)
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .layer(middleware::from_fn_with_state(state.clone(), first_check))
        .with_state(state)
}

/// The name of the server before anything else; fixed headers in every answer.
async fn first_check(
    State(state): Ours,
    ConnectInfo(idle): ConnectInfo<Idle>,
    request: Request,
    next: Next,
) -> Response {
    let access = &state.services.access;
    let for_us = access.is_for_us(request.uri(), request.headers());
    // From here on the connection is not closed in favour of another one.
    if for_us && access.role(request.headers()).is_some() {
        idle.trust();
        idle.serve();
    }
    let mut response = if for_us {
        next.run(request).await
    } else {
        let text = "this is not the name of this server; use 127.0.0.1 or localhost\n";
        plain::line(StatusCode::FORBIDDEN, text)
    };
    // Counted from the end of the answer, not of the request.
    idle.restart();
    let headers = response.headers_mut();
    // Also on refusals: they are pages as well and could be framed.
    let fixed = [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_FRAME_OPTIONS, "DENY"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

#[derive(Deserialize)]
struct Entry {
    token: Option<String>,
}

/// The page and its files.
async fn file(
    State(state): Ours,
    method: Method,
    uri: Uri,
    headers: HeaderMap,
    entry: Result<Query<Entry>, QueryRejection>,
) -> Response {
    if method != Method::GET && method != Method::HEAD {
        return plain::line(StatusCode::METHOD_NOT_ALLOWED, "only GET\n");
    }
    let access = &state.services.access;
    let token = entry.ok().and_then(|Query(entry)| entry.token);
    // Only on the page itself: a token elsewhere would end up in a cache or a log.
    if let (Some(token), "/") = (token, uri.path()) {
        return match access.exchange(&token) {
            Exchange::Role(role) => enter(&access.set_cookie(role)),
            // A browser that has its cookie opened an old link: no reason to refuse it.
            Exchange::Used | Exchange::Wrong if access.role(&headers).is_some() => to_page(),
            Exchange::Used => plain::used_token(),
            Exchange::Wrong => plain::wrong_token(),
        };
    }
    if access.role(&headers).is_none() {
        return plain::no_cookie();
    }
    let services = &state.services;
    if let Some(mesh) = uri.path().strip_prefix("/meshes") {
        return file_response::plain(services.meshes.get(mesh), mesh);
    }
    if uri.path() == "/" && !services.files.has_page() {
        return plain::no_page(&services.hint);
    }
    file_response::of(&services.files, uri.path(), &headers)
}

/// Redirects to the page without a token in its address.
fn to_page() -> Response {
    (StatusCode::SEE_OTHER, [(header::LOCATION, "/")]).into_response()
}

fn enter(cookie: &str) -> Response {
    let mut response = to_page();
    put_cookie(&mut response, cookie);
    response
}

fn put_cookie(response: &mut Response, cookie: &str) {
    if let Ok(value) = HeaderValue::from_str(cookie) {
        response.headers_mut().insert(header::SET_COOKIE, value);
    }
    plain::no_store(response);
}

async fn scene(State(state): Ours, method: Method, headers: HeaderMap) -> Response {
    match refusal(&state, &method, &headers) {
        Some(refused) => refused,
        None => json(state.services.broadcast.scene().to_string()),
    }
}

/// One incident, as the launcher wrote it.
async fn incident(
    State(state): Ours,
    method: Method,
    headers: HeaderMap,
    number: Result<Path<u32>, PathRejection>,
) -> Response {
    if let Some(refused) = refusal(&state, &method, &headers) {
        return refused;
    }
    let number = number.ok().map(|Path(number)| number);
    match number.and_then(|number| state.services.incidents.bytes(number)) {
        Some(text) => json(text),
        None => plain::line(StatusCode::NOT_FOUND, "no such incident is kept\n"),
    }
}

/// Frames of a span of the recording, one after the other.
async fn past(
    State(state): Ours,
    method: Method,
    headers: HeaderMap,
    span: Result<Query<PastSpan>, QueryRejection>,
) -> Response {
    if let Some(refused) = refusal(&state, &method, &headers) {
        return refused;
    }
    let open = state.services.past.clone();
    let Some(span) = span.ok().map(|Query(span)| span).filter(PastSpan::is_valid) else {
        return plain::line(
            StatusCode::BAD_REQUEST,
            "from_s, to_s (at most 600 s) and count (2 to 1000) are needed\n",
        );
    };
    // Refused, not queued: reading for a page that shows another time by then is wasted.
    let Ok(_permit) = state.readers.try_acquire() else {
        return plain::line(
            StatusCode::SERVICE_UNAVAILABLE,
            "another page reads; try again\n",
        );
    };
    // Reading takes a tenth of a second; other pages do not wait for it.
    let read = tokio::task::spawn_blocking(move || open()?.frames(&span)).await;
    match read {
        Ok(Ok(frames)) => {
            let kind = [(header::CONTENT_TYPE, "application/octet-stream")];
            let mut response = (kind, frames).into_response();
            plain::no_store(&mut response);
            response
        }
        _ => plain::line(StatusCode::NOT_FOUND, "this time is not recorded\n"),
    }
}

/// The grasps of an object by an arm.
async fn grasps(
    State(state): Ours,
    method: Method,
    headers: HeaderMap,
    indices: Result<Path<(usize, usize)>, PathRejection>,
) -> Response {
    if let Some(refused) = refusal(&state, &method, &headers) {
        return refused;
    }
    let Ok(Path((arm, object))) = indices else {
        return plain::line(StatusCode::NOT_FOUND, "ARM/OBJECT are two indices\n");
    };
    search(&state, Search::Grasps(arm, object)).await
}

/// The joint positions that bring the TCP of an arm to a pose.
async fn joints(
    State(state): Ours,
    method: Method,
    headers: HeaderMap,
    parts: Result<Path<(usize, String)>, PathRejection>,
) -> Response {
    if let Some(refused) = refusal(&state, &method, &headers) {
        return refused;
    }
    let pose = |text: &str| -> Option<[f64; 7]> {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
        let numbers: [f64; 7] = numbers.ok()?.try_into().ok()?;
        let is_unit = (numbers[3..].iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1.0e-2;
        (numbers.iter().all(|x| x.is_finite()) && is_unit).then_some(numbers)
    };
    let parts = parts.ok().map(|Path((arm, text))| (arm, pose(&text)));
    let Some((arm, Some(pose))) = parts else {
        let allowed = "ARM/POSE are an index, and x,y,z,w,x,y,z with a unit quaternion\n";
        return plain::line(StatusCode::NOT_FOUND, allowed);
    };
    search(&state, Search::Joints(arm, pose)).await
}

async fn search(state: &AppState, of: Search) -> Response {
    let Some(search) = state.services.search.clone() else {
        return plain::line(StatusCode::NOT_FOUND, "only a live cell is searched\n");
    };
    let Ok(permit) = state.searches.clone().try_acquire_owned() else {
        return plain::line(
            StatusCode::SERVICE_UNAVAILABLE,
            "another page searches; try again\n",
        );
    };
    // The inverse kinematics of all candidates take up to seconds.
    let search = move || {
        // Kept by the search: it continues when the page has left.
        let _permit = permit;
        search(of)
    };
    match tokio::task::spawn_blocking(search).await {
        Ok(Ok(found)) => json(found),
        Ok(Err(why)) => plain::line(StatusCode::NOT_FOUND, format!("{why}\n")),
        Err(_) => plain::line(StatusCode::INTERNAL_SERVER_ERROR, "the search failed\n"),
    }
}

/// The refusal of a request for data that is not a GET or has no role.
fn refusal(state: &AppState, method: &Method, headers: &HeaderMap) -> Option<Response> {
    if method != Method::GET {
        return Some(plain::line(StatusCode::METHOD_NOT_ALLOWED, "only GET\n"));
    }
    let needed = "a cookie or a bearer token is needed\n";
    let is_known = state.services.access.role(headers).is_some();
    (!is_known).then(|| plain::line(StatusCode::UNAUTHORIZED, needed))
}

fn json(text: impl Into<Body>) -> Response {
    let headers = [
        (header::CONTENT_TYPE, "application/json"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    (headers, text.into()).into_response()
}

#[derive(Deserialize)]
struct TokenBody {
    token: String,
}

/// Gives a viewer the role of an operator.
async fn token(
    State(state): Ours,
    headers: HeaderMap,
    body: Result<axum::Json<TokenBody>, JsonRejection>,
) -> Response {
    let access = &state.services.access;
    // Another site could otherwise change the role of this browser.
    if !access.is_from_us(&headers) {
        return plain::line(
            StatusCode::FORBIDDEN,
            "a page of another origin may not do this\n",
        );
    }
    let Ok(axum::Json(TokenBody { token })) = body else {
        return plain::line(
            StatusCode::BAD_REQUEST,
            "a JSON object with `token` is needed\n",
        );
    };
    let Some(role) = access.role_of_token(&token) else {
        return plain::line(StatusCode::FORBIDDEN, "this is not the token of this run\n");
    };
    let mut response = StatusCode::NO_CONTENT.into_response();
    put_cookie(&mut response, &access.set_cookie(role));
    response
}

async fn websocket(
    State(state): Ours,
    ConnectInfo(idle): ConnectInfo<Idle>,
    headers: HeaderMap,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Response {
    let access = &state.services.access;
    // Browsers let any site open a websocket: only the origin tells them apart.
    if !access.is_from_us(&headers) {
        return plain::line(
            StatusCode::FORBIDDEN,
            "a page of another origin may not do this\n",
        );
    }
    let Some(role) = access.role(&headers) else {
        return plain::line(
            StatusCode::UNAUTHORIZED,
            "a cookie or a bearer token is needed\n",
        );
    };
    let Ok(upgrade) = upgrade else {
        return plain::line(StatusCode::BAD_REQUEST, "this is for websockets\n");
    };
    // Before the upgrade, so that a page that is one too many gets a readable refusal.
    let Ok(permit) = state.sockets.clone().try_acquire_owned() else {
        return plain::line(StatusCode::SERVICE_UNAVAILABLE, "too many pages are open\n");
    };
    socket::limit(upgrade).on_upgrade(move |socket| async move {
        // A websocket is tested by pings instead.
        idle.switch_off();
        socket::serve(socket, state, role).await;
        drop(permit);
    })
}

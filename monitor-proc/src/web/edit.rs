//! The policy of a live cell as a file: shown, checked and replaced.
//!
//! Three checks come before a text is looked at: the origin of the request, the operator's
//! role, and that no other check is running. A viewer must not start a program.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::State;
use axum::extract::rejection::JsonRejection;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::sync::oneshot;
use tokio::task::spawn_blocking;

use super::plain;
use super::state::AppState;
use crate::operator::policy_file::Fault;
use crate::page::command::Order;
use crate::page::queue::Reply;
use crate::page::role::Role;

/// Largest text (bytes).
// A page of text, and as large as a browser edits without delay.
pub(super) const MAX_TEXT: usize = 1 << 20;

#[derive(Deserialize)]
pub(super) struct Edit {
    text: String,
    apply: bool,
}

/// The file of the policy that is running.
pub(super) async fn read(State(state): State<Arc<AppState>>, headers: HeaderMap) -> Response {
    if state.services.access.role(&headers).is_none() {
        return plain::line(
            StatusCode::UNAUTHORIZED,
            "a cookie or a bearer token is needed\n",
        );
    }
    let Some(files) = state.services.policies.clone() else {
        let why = "a recording has no policy to edit";
        return answer(&json!({ "kind": null, "name": null, "why": why }));
    };
    let policy = state.services.broadcast.policy();
    // Files are read on another thread: a slow disk must not stop the frames of all pages.
    match spawn_blocking(move || files.read(&policy)).await {
        Ok(message) => answer(&message),
        Err(_) => plain::line(StatusCode::INTERNAL_SERVER_ERROR, "the file was not read\n"),
    }
}

/// Checks a text; with `apply` it replaces the file, and the task is restarted.
pub(super) async fn write(
    State(state): State<Arc<AppState>>,
    headers: HeaderMap,
    edit: Result<axum::Json<Edit>, JsonRejection>,
) -> Response {
    let access = &state.services.access;
    // A page of another port of this host has the cookie as well; its origin differs.
    if !access.is_from_us(&headers) {
        let text = "a page of another origin may not do this\n";
        return plain::line(StatusCode::FORBIDDEN, text);
    }
    if access.role(&headers) != Some(Role::Operator) {
        return plain::line(StatusCode::FORBIDDEN, "a viewer may not do this\n");
    }
    let Ok(axum::Json(edit)) = edit else {
        let text = "a JSON object with `text` and `apply`, at most 1 MiB, is needed\n";
        return plain::line(StatusCode::BAD_REQUEST, text);
    };
    let Some(files) = state.services.policies.clone() else {
        return plain::line(StatusCode::NOT_FOUND, "a recording has no policy to edit\n");
    };
    // One at a time: a check starts a program and copies the cell.
    let Ok(_permit) = state.edits.try_acquire() else {
        let text = "another text is being checked; try again\n";
        return plain::line(StatusCode::SERVICE_UNAVAILABLE, text);
    };
    let (policy, apply) = (state.services.broadcast.policy(), edit.apply);
    let checked = spawn_blocking(move || {
        // Checked and written in one job, so that no other text is written in between.
        files.check(&policy, &edit.text)?;
        if !apply {
            return Ok("no errors".to_owned());
        }
        let written = files.write(&policy, &edit.text);
        written.map_err(|message| vec![Fault::without_place(message)])
    });
    match checked.await {
        Ok(Ok(message)) if apply => restart(&state, &message).await,
        Ok(Ok(message)) => answer(&json!({ "ok": true, "message": message })),
        Ok(Err(faults)) => answer(&json!({ "ok": false, "errors": faults })),
        Err(_) => plain::line(
            StatusCode::INTERNAL_SERVER_ERROR,
            "the text was not checked\n",
        ),
    }
}

// Through the command queue, like a restart by hand: the log names it, and the launcher decides.
async fn restart(state: &AppState, message: &str) -> Response {
    let (answered, reply) = oneshot::channel();
    let line = json!({ "ask": "restart", "process": "task", "policy": null });
    let description = "edit of the policy, restart task";
    state
        .services
        .queue
        .push(Order::Launch(line), description, answered);
    let reply = reply
        .await
        .unwrap_or_else(|_| Reply::refused("the monitor is ending"));
    if reply.ok {
        return answer(&json!({ "ok": true, "message": message }));
    }
    // The file is written all the same, so the answer has both.
    let fault = Fault::without_place(format!("{message}, but: {}", reply.message));
    answer(&json!({ "ok": false, "errors": [fault] }))
}

fn answer(message: &Value) -> Response {
    let kind = [(header::CONTENT_TYPE, "application/json")];
    let mut response = (kind, Body::from(message.to_string())).into_response();
    plain::no_store(&mut response);
    response
}

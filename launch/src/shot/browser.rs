//! A browser without a window, led over its debugging socket.

use std::fs;
use std::io::ErrorKind;
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

use crate::failure::{Context, Failure};

/// Names under which distributions install it.
pub(crate) const PROGRAMS: [&str; 5] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
];
/// Quiet, alone, and with a renderer that needs no GPU.
const FLAGS: [&str; 12] = [
    "--headless=new",
    "--remote-debugging-port=0",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
];
/// Longest wait before it is looked whether the user stopped us.
const LOOK: Duration = Duration::from_millis(200);
/// Start, and each answer.
const PATIENCE: Duration = Duration::from_secs(60);

/// See the module. Ends with its value.
pub(crate) struct Browser {
    child: Child,
    profile: PathBuf,
    socket: WebSocket<TcpStream>,
    session: String,
    last: u64,
}

impl Browser {
    /// Starts one with a page of this size (pixels).
    pub(crate) fn start(width: u32, height: u32) -> Result<Self, Failure> {
        let profile = std::env::temp_dir().join(format!("robocell-browser-{}", std::process::id()));
        fs::create_dir_all(&profile).cannot("make a profile for the browser")?;
        let mut child = spawn(&profile, width, height)?;
        let socket = connect(&profile, &mut child).inspect_err(|_| {
            child.kill().ok();
            child.wait().ok();
            fs::remove_dir_all(&profile).ok();
        })?;
        let mut browser = Self {
            child,
            profile,
            socket,
            session: String::new(),
            last: 0,
        };
        let target = browser.call("Target.createTarget", &json!({"url": "about:blank"}))?;
        let attach = json!({"targetId": target["targetId"], "flatten": true});
        let attached = browser.call("Target.attachToTarget", &attach)?;
        attached["sessionId"]
            .as_str()
            .unwrap_or_default()
            .clone_into(&mut browser.session);
        let metrics =
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        browser.call("Emulation.setDeviceMetricsOverride", &metrics)?;
        Ok(browser)
    }

    /// Sets a cookie of `url`.
    pub(crate) fn set_cookie(&mut self, url: &str, name: &str, value: &str) -> Result<(), Failure> {
        let cookie = json!({"url": url, "name": name, "value": value});
        self.call("Network.setCookie", &cookie)?;
        Ok(())
    }

    /// Goes to `url`.
    pub(crate) fn open(&mut self, url: &str) -> Result<(), Failure> {
        let gone = self.call("Page.navigate", &json!({"url": url}))?;
        match gone["errorText"].as_str() {
            None => Ok(()),
            Some(error) => Err(Failure::configuration(format!(
                "the browser cannot open the page: {error}"
            ))),
        }
    }

    /// Value of a JavaScript expression on the page; null where it throws.
    pub(crate) fn evaluate(&mut self, expression: &str) -> Result<Value, Failure> {
        let ask = json!({"expression": expression, "returnByValue": true});
        let mut answer = self.call("Runtime.evaluate", &ask)?;
        Ok(answer["result"]["value"].take())
    }

    /// The page as PNG.
    pub(crate) fn picture(&mut self) -> Result<Vec<u8>, Failure> {
        self.picture_of(None)
    }

    /// A part of the page as PNG.
    pub(crate) fn picture_of(&mut self, clip: Option<&Value>) -> Result<Vec<u8>, Failure> {
        let mut ask = json!({"format": "png"});
        if let Some(clip) = clip {
            ask["clip"] = clip.clone();
        }
        let answer = self.call("Page.captureScreenshot", &ask)?;
        let data = answer["data"].as_str().unwrap_or_default();
        STANDARD.decode(data).cannot("read the browser's picture")
    }

    fn call(&mut self, method: &str, parameters: &Value) -> Result<Value, Failure> {
        self.last += 1;
        let mut call = json!({"id": self.last, "method": method, "params": parameters});
        if !self.session.is_empty() {
            call["sessionId"] = json!(self.session);
        }
        let what = format!("ask the browser for {method}");
        self.socket
            .send(Message::text(call.to_string()))
            .cannot(&what)?;
        let since = Instant::now();
        while since.elapsed() < PATIENCE {
            super::not_stopped()?;
            let text = match self.socket.read() {
                Ok(Message::Text(text)) => text,
                Ok(_) => continue,
                Err(tungstenite::Error::Io(error)) if is_no_end(error.kind()) => continue,
                Err(error) => return Err(error).cannot(&what),
            };
            let mut answer: Value = serde_json::from_str(&text).cannot(&what)?;
            if answer["id"] != json!(self.last) {
                continue;
            }
            return match answer["error"]["message"].as_str() {
                Some(error) => Err(Failure::configuration(format!("cannot {what}: {error}"))),
                None => Ok(answer["result"].take()),
            };
        }
        Err(Failure::configuration(format!("cannot {what}: no answer")))
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
        fs::remove_dir_all(&self.profile).ok();
    }
}

fn spawn(profile: &std::path::Path, width: u32, height: u32) -> Result<Child, Failure> {
    for program in PROGRAMS {
        let mut command = Command::new(program);
        command
            .args(FLAGS)
            .arg(format!("--user-data-dir={}", profile.display()))
            .arg(format!("--window-size={width},{height}"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        // Its sandbox refuses to work for root.
        if cell_rt::process::user_id() == 0 {
            command.arg("--no-sandbox");
        }
        match command.arg("about:blank").spawn() {
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            other => return other.cannot(format!("start {program}")),
        }
    }
    Err(Failure::configuration(
        "a picture needs Chromium or Chrome: install it (Debian: `apt install chromium`)",
    ))
}

/// Nothing came within [`LOOK`], or a signal arrived.
fn is_no_end(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

/// The browser writes port and path of its socket to a file of its profile.
fn connect(profile: &std::path::Path, child: &mut Child) -> Result<WebSocket<TcpStream>, Failure> {
    let file = profile.join("DevToolsActivePort");
    let since = Instant::now();
    loop {
        super::not_stopped()?;
        let text = fs::read_to_string(&file).unwrap_or_default();
        let mut lines = text.lines();
        if let (Some(port), Some(path)) = (lines.next(), lines.next()) {
            let what = "reach the browser";
            let stream = TcpStream::connect(format!("127.0.0.1:{port}")).cannot(what)?;
            stream.set_read_timeout(Some(PATIENCE)).cannot(what)?;
            let url = format!("ws://127.0.0.1:{port}{path}");
            let (socket, _) = tungstenite::client(url, stream).cannot(what)?;
            let within = socket.get_ref().set_read_timeout(Some(LOOK));
            within.cannot(what)?;
            return Ok(socket);
        }
        if let Some(status) = child.try_wait().cannot("look at the browser")? {
            return Err(Failure::configuration(format!(
                "the browser ended at its start ({status}); run it by hand to see why"
            )));
        }
        if since.elapsed() > PATIENCE {
            return Err(Failure::configuration("the browser does not start"));
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

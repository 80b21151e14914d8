//! `robocell film`: the page as a moving picture, frame by frame from what was recorded.

use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};

use serde_json::json;

use super::browser::Browser;
use super::cell::{Shown, Subject};
use super::{not_stopped, open_page, wait_for};
use crate::cli::{FilmArgs, FilmPart};
use crate::failure::{Context, Failure};
use crate::progress::Progress;
use crate::run::plan::new_file;
use crate::say;

/// A film of more frames takes hours without a GPU.
const MAX_FRAMES: f64 = 20_000.0;
/// Colours of a GIF: a scene has few, and each costs room.
const GIF: &str = "split[a][b];[a]palettegen=max_colors=96:stats_mode=diff[p];[b][p]paletteuse=dither=none:diff_mode=rectangle";

/// Makes the film.
pub(crate) fn film(args: &FilmArgs) -> Result<(), Failure> {
    let out = new_file(&args.out)?;
    let times = times(args)?;
    let encoder_words = encoder_words(&args.out, args.fps)?;
    cell_rt::signal::install_stop_handler().cannot("listen to signals")?;
    let progress = Progress::new("starting the cell");
    let shown = Shown::of(&Subject {
        args: &args.shown,
        time: args.shown.demo.is_some().then_some(args.to),
        cell: &args.cell.cell,
    })?;
    // As for a picture: the cell goes first.
    cell_rt::priority::set_idle().ok();
    let (width, height) = args.size;
    let mut browser = Browser::start(width, height)?;
    let fragment = args
        .view
        .iter()
        .cloned()
        .chain([format!("t={}", args.from)]);
    open_page(&mut browser, shown.entry(), fragment)?;
    let clip = match args.part {
        FilmPart::Page => None,
        FilmPart::View => Some(place_of_view(&mut browser)?),
    };
    let mut encoder = Encoder::start(&encoder_words, &out)?;
    for (frame, time) in times.iter().enumerate() {
        not_stopped()?;
        progress.say(format!("frame {} of {}", frame + 1, times.len()));
        seek(&mut browser, *time)?;
        let frame = browser.picture_of(clip.as_ref())?;
        encoder.take(&frame)?;
    }
    encoder.end()?;
    drop(progress);
    let (frames, speed) = (times.len(), args.speed);
    say::line(format_args!(
        "{}: {frames} frames, {:.1} s of the cell at {speed} times its speed",
        out.display(),
        args.to - args.from
    ));
    Ok(())
}

/// Simulated times of the frames (s).
fn times(args: &FilmArgs) -> Result<Vec<f64>, Failure> {
    let step = args.speed / f64::from(args.fps);
    let length = args.to - args.from;
    if length < step || length / step > MAX_FRAMES {
        return Err(Failure::usage(format!(
            "--from {} and --to {} make a film of {:.0} frames; allowed are 1 to {MAX_FRAMES}",
            args.from,
            args.to,
            (length / step).max(0.0)
        )));
    }
    let mut times = Vec::new();
    let mut time = args.from;
    while time <= args.to {
        times.push(time);
        time += step;
    }
    Ok(times)
}

fn encoder_words(out: &Path, fps: u32) -> Result<Vec<String>, Failure> {
    let ending = out.extension().and_then(|ending| ending.to_str());
    let codec: &[&str] = match ending {
        Some("gif") => &["-vf", GIF],
        Some("mp4") => &[
            "-vf",
            "pad=ceil(iw/2)*2:ceil(ih/2)*2",
            "-pix_fmt",
            "yuv420p",
            "-crf",
            "26",
        ],
        _ => {
            return Err(Failure::usage(format!(
                "{}: a film is a file .mp4 or .gif",
                out.display()
            )));
        }
    };
    let fps = fps.to_string();
    let input = [
        "-loglevel",
        "error",
        "-f",
        "image2pipe",
        "-framerate",
        &fps,
        "-i",
        "-",
    ];
    Ok(input
        .iter()
        .chain(codec)
        .map(|word| (*word).to_owned())
        .collect())
}

/// Goes to a moment of the past, and waits until it is drawn.
fn seek(browser: &mut Browser, time_s: f64) -> Result<(), Failure> {
    browser.evaluate(&format!(
        "(() => {{ const {{ store }} = window.robocell; window.filmed = false;\
         store.send({{ do: 'seek', time_s: {time_s} }}).then(() => {{\
           const look = (calm) => {{\
             const near = Math.abs(store.snapshot.time - {time_s}) < 0.05;\
             if (near && calm > 2) window.filmed = true;\
             else requestAnimationFrame(() => look(near ? calm + 1 : 0));\
           }}; look(0); }}); }})()"
    ))?;
    wait_for(browser, "window.filmed === true", "the next moment")
}

/// Where the 3D view is on the page, as a clip of the picture.
fn place_of_view(browser: &mut Browser) -> Result<serde_json::Value, Failure> {
    let place = browser.evaluate(
        "(() => { const { x, y, width, height } = document.getElementById('view').getBoundingClientRect();\
         return [x, y, width, height]; })()",
    )?;
    let at = |index: usize| place[index].as_f64().unwrap_or_default();
    Ok(json!({ "x": at(0), "y": at(1), "width": at(2), "height": at(3), "scale": 1 }))
}

/// ffmpeg, which takes pictures and writes the file.
struct Encoder {
    child: Child,
    input: Option<ChildStdin>,
}

impl Encoder {
    fn start(words: &[String], out: &Path) -> Result<Self, Failure> {
        let started = Command::new("ffmpeg")
            .args(words)
            .arg(out)
            .stdin(Stdio::piped())
            .spawn();
        let mut child = match started {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                return Err(Failure::configuration(
                    "a film needs ffmpeg: install it (Debian: `apt install ffmpeg`)",
                ));
            }
            started => started.cannot("start ffmpeg")?,
        };
        let input = child.stdin.take();
        Ok(Self { child, input })
    }

    fn take(&mut self, frame: &[u8]) -> Result<(), Failure> {
        let written = self.input.as_mut().map(|input| input.write_all(frame));
        written.unwrap_or(Ok(())).cannot("hand a frame to ffmpeg")
    }

    fn end(mut self) -> Result<(), Failure> {
        self.input = None;
        let status = self.child.wait().cannot("wait for ffmpeg")?;
        if status.success() {
            return Ok(());
        }
        Err(Failure::configuration(format!(
            "ffmpeg ended with {status}, see above"
        )))
    }
}

impl Drop for Encoder {
    fn drop(&mut self) {
        self.input = None;
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

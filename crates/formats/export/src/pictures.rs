//! Pictures of a data set: a lossless video by `ffmpeg` where it is on PATH, else PNG.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use camera::Picture;

use crate::ExportError;

/// How the pictures are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Storage {
    /// Files of h264, without loss.
    Video,
    /// In the tables.
    Png,
}

impl Storage {
    /// By what this machine has.
    pub(crate) fn here() -> Self {
        let mut asked = Command::new("ffmpeg");
        asked.args(["-v", "error", "-h", "encoder=libx264rgb"]);
        let said = asked.stdin(Stdio::null()).output();
        // An ffmpeg without this encoder says so on standard output, and ends well.
        let knows = said.is_ok_and(|said| {
            said.status.success() && String::from_utf8_lossy(&said.stdout).contains("libx264rgb")
        });
        if knows { Self::Video } else { Self::Png }
    }
}

/// A picture as PNG.
pub(crate) fn png(picture: &Picture) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.rgb)?;
    writer.finish()?;
    Ok(bytes)
}

/// A video that grows by frames.
pub(crate) struct Video {
    child: Child,
    path: PathBuf,
    /// Frames so far.
    pub(crate) frames: u64,
}

impl Video {
    /// Starts a video of these pixels.
    pub(crate) fn create(
        path: &Path,
        (width, height): (u32, u32),
        rate_hz: u32,
    ) -> Result<Self, ExportError> {
        if let Some(dir) = path.parent() {
            std::fs::create_dir_all(dir).map_err(|error| ExportError::io(dir, error))?;
        }
        let mut command = Command::new("ffmpeg");
        command.args(["-v", "error", "-f", "rawvideo", "-pixel_format", "rgb24"]);
        command.args(["-video_size", &format!("{width}x{height}")]);
        command.args(["-framerate", &rate_hz.to_string(), "-i", "-", "-an"]);
        // Without loss. A reader seeks to any frame: no B frames, and every second one a key
        // frame. One thread and no name of the encoder: the same bytes every time.
        command.args(["-c:v", "libx264rgb", "-crf", "0", "-preset", "veryfast"]);
        command.args(["-threads", "1", "-bf", "0", "-g", "2"]);
        command.args(["-fflags", "+bitexact", "-flags:v", "+bitexact", "-y"]);
        // stderr is inherited, so that the user sees the message of ffmpeg itself.
        command
            .arg(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null());
        let child = command
            .spawn()
            .map_err(|error| ExportError::io(path, error))?;
        Ok(Self {
            child,
            path: path.to_owned(),
            frames: 0,
        })
    }

    /// Adds a frame.
    pub(crate) fn add(&mut self, picture: &Picture) -> Result<(), ExportError> {
        let written = match &mut self.child.stdin {
            Some(input) => input.write_all(&picture.rgb),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        };
        written.map_err(|error| ExportError::io(&self.path, error))?;
        self.frames += 1;
        Ok(())
    }

    /// Bytes that are on the disk so far.
    pub(crate) fn bytes(&self) -> u64 {
        // ffmpeg may not have created the file yet.
        std::fs::metadata(&self.path).map_or(0, |about| about.len())
    }

    /// Ends the file.
    pub(crate) fn close(mut self) -> Result<(), ExportError> {
        // ffmpeg writes the index of the file when its input ends: with an open pipe `wait` would
        // not return.
        drop(self.child.stdin.take());
        let ended = self.child.wait();
        let ended = ended.map_err(|error| ExportError::io(&self.path, error))?;
        if ended.success() {
            return Ok(());
        }
        Err(ExportError::episode(
            &self.path,
            format!("ffmpeg ended with {ended}; its message is above"),
        ))
    }
}

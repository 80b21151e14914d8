//! `camera`: what the cameras of a cell see at a time of a run.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use camera::{Picture, UnknownCamera};
use cell_run::spec::RunSpec;
use cell_sim::{OneProcess, Program, SimError};
use clap::Args;
use png::{BitDepth, ColorType, Encoder, EncodingError};

use crate::output::print_line;

/// What to draw.
#[derive(Args)]
pub(crate) struct CameraArgs {
    /// The run file.
    #[arg(long)]
    pub(crate) spec: PathBuf,
    /// Simulated time (s).
    #[arg(long)]
    time: f64,
    /// Names of the cameras.
    #[arg(long)]
    camera: Vec<String>,
    /// Print hashes.
    #[arg(long)]
    hash: bool,
    /// Directory for pictures.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Why no picture is drawn.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CameraError {
    /// The run.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The cell has no such camera.
    #[error("robocell: --camera: {0}")]
    Unknown(#[from] UnknownCamera),
    /// The run ended before the time of the picture.
    #[error("robocell: the run ended at {at_s:.3} s, before --time {wanted_s} s")]
    Ended { at_s: f64, wanted_s: f64 },
    /// A file could not be written.
    #[error("robocell: cannot write {path}: {source}")]
    Write { path: String, source: EncodingError },
}

/// Runs the cell up to the time and draws it.
pub(crate) fn run(program: &Program, args: &CameraArgs) -> Result<ExitCode, CameraError> {
    let spec = RunSpec::load(&args.spec).map_err(SimError::from)?;
    let cell = spec.load_cell_from(&program.data).map_err(SimError::from)?;
    // Before the run: a wrong name must not cost its time.
    let sees = |sim: &OneProcess| camera::observe(&cell, sim.state(), &args.camera);
    let mut sim = OneProcess::with(&program.policies, &program.controllers, &spec, cell.clone())?;
    sees(&sim)?;
    let ticks = (args.time * 1000.0).round();
    while (sim.state().header.tick as f64) < ticks {
        if !sim.tick()? {
            let (at_s, wanted_s) = (sim.state().header.tick as f64 * 1.0e-3, args.time);
            return Err(CameraError::Ended { at_s, wanted_s });
        }
    }
    let pictures = sees(&sim)?;
    for (name, picture) in args.camera.iter().zip(&pictures) {
        if args.hash {
            let [rgb, depth, mask] = picture.hashes();
            print_line(format_args!(
                "{name}: rgb {rgb:016x}, depth {depth:016x}, mask {mask:016x}"
            ));
        }
        if let Some(dir) = &args.out {
            write(dir, name, picture)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes colour, depth and mask of a picture.
fn write(dir: &Path, name: &str, picture: &Picture) -> Result<(), CameraError> {
    let depth = picture.depth_m.iter().copied().flat_map(millimetres);
    let mask = picture.mask.iter().flat_map(|number| number.to_be_bytes());
    let (depth, mask): (Vec<u8>, Vec<u8>) = (depth.collect(), mask.collect());
    let wide = (ColorType::Grayscale, BitDepth::Sixteen);
    for (kind, format, bytes) in [
        ("", (ColorType::Rgb, BitDepth::Eight), &picture.rgb),
        (".depth", wide, &depth),
        (".mask", wide, &mask),
    ] {
        let path = dir.join(format!("{name}{kind}.png"));
        let size = (picture.width, picture.height);
        encode(&path, size, format, bytes).map_err(|source| CameraError::Write {
            path: path.display().to_string(),
            source,
        })?;
    }
    Ok(())
}

/// A depth (m) as a pixel of 16 bits.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates: 65.5 m, and a depth is not negative"
)]
fn millimetres(depth_m: f32) -> [u8; 2] {
    ((depth_m * 1000.0).round() as u16).to_be_bytes()
}

fn encode(
    path: &Path,
    (width, height): (u32, u32),
    (colour, bits): (ColorType, BitDepth),
    bytes: &[u8],
) -> Result<(), EncodingError> {
    if let Some(dir) = path.parent() {
        std::fs::create_dir_all(dir)?;
    }
    let mut encoder = Encoder::new(BufWriter::new(File::create(path)?), width, height);
    encoder.set_color(colour);
    encoder.set_depth(bits);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()
}

//! The same scene in `MuJoCo`, in a Python beside this process, where that has
//! the package.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use crate::report::Samples;
use cell_model::{Cell, Shape};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

const PROGRAM: &str = include_str!("mujoco.py");

/// `MuJoCo` with a scene.
pub(crate) struct Mujoco {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    version: String,
}

impl Mujoco {
    /// Sets the objects and fixtures of a cell up; `None` where there is no
    /// Python with `MuJoCo`.
    pub(crate) fn start(cell: &Cell) -> Option<Self> {
        let mut child = Command::new("python3")
            .args(["-c", PROGRAM])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut requests = child.stdin.take()?;
        let answers = BufReader::new(child.stdout.take()?);
        let scene = mjcf(cell);
        let sent = write!(requests, "{}\n{scene}", scene.len()).and_then(|()| requests.flush());
        let mut mujoco = Self {
            child,
            requests,
            answers,
            version: String::new(),
        };
        sent.ok()?;
        mujoco.version = mujoco.line()?;
        Some(mujoco)
    }

    /// Its version.
    pub(crate) fn version(&self) -> &str {
        &self.version
    }

    /// Steps, and takes the times.
    pub(crate) fn step(&mut self, steps: usize, samples: &mut Samples) {
        let asked = writeln!(self.requests, "{steps}").and_then(|()| self.requests.flush());
        let answer = asked.ok().and_then(|()| self.line()).unwrap_or_default();
        let times = answer.split(' ').filter_map(|time| time.parse().ok());
        times.for_each(|time_ns| samples.record(time_ns));
    }

    fn line(&mut self) -> Option<String> {
        let mut line = String::new();
        let read = self.answers.read_line(&mut line).ok()?;
        (read > 0).then(|| line.trim().to_owned())
    }
}

impl Drop for Mujoco {
    fn drop(&mut self) {
        let _ended = self.child.kill();
        let _waited = self.child.wait();
    }
}

/// The scene in `MuJoCo`'s own format, with its own settings but for the length
/// of the step.
fn mjcf(cell: &Cell) -> String {
    let mut out = String::from("<mujoco><option timestep=\"0.001\"/><worldbody>\n");
    for fixture in &cell.fixtures {
        geoms(
            &mut out,
            &fixture.shape,
            &fixture.pose,
            1.0,
            fixture.friction,
        );
    }
    for object in &cell.objects {
        let _infallible = writeln!(out, "<body {}><freejoint/>", placed(&object.pose));
        let (mass, friction) = (object.mass, object.friction);
        geoms(
            &mut out,
            &object.shape,
            &Isometry3::identity(),
            mass,
            friction,
        );
        out.push_str("</body>\n");
    }
    out.push_str("</worldbody></mujoco>\n");
    out
}

fn geoms(out: &mut String, shape: &Shape, pose: &Isometry3<f64>, mass: f64, friction: f64) {
    if let Some(panels) = shape.panels() {
        let volume: f64 = panels.iter().map(|panel| panel.size.product()).sum();
        for panel in panels {
            let size = panel.size;
            let own = Isometry3::from_parts(panel.centre.into(), UnitQuaternion::identity());
            let shape = Shape::Box {
                size_m: size.into(),
            };
            geoms(
                out,
                &shape,
                &(pose * own),
                mass * size.product() / volume,
                friction,
            );
        }
        return;
    }
    let (kind, size) = match *shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => {
            ("box", (0.5 * Vector3::from(size_m)).as_slice().to_vec())
        }
        Shape::Sphere { radius_m } => ("sphere", vec![radius_m]),
        Shape::Cylinder { radius_m, height_m } => ("cylinder", vec![radius_m, 0.5 * height_m]),
        Shape::Capsule { radius_m, height_m } => ("capsule", vec![radius_m, 0.5 * height_m]),
    };
    let size: Vec<String> = size.iter().map(f64::to_string).collect();
    let _infallible = writeln!(
        out,
        "<geom type=\"{kind}\" size=\"{}\" {} mass=\"{mass}\" friction=\"{friction} 0.005 0.0001\"/>",
        size.join(" "),
        placed(pose)
    );
}

fn placed(pose: &Isometry3<f64>) -> String {
    let (p, q) = (pose.translation.vector, pose.rotation);
    format!(
        "pos=\"{} {} {}\" quat=\"{} {} {} {}\"",
        p.x, p.y, p.z, q.w, q.i, q.j, q.k
    )
}

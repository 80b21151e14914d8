//! Writes an XRDF.

use std::collections::BTreeMap;
use std::fmt::Write;

use cell_model::Robot;
use rmp::CollisionSphere;

use crate::spheres::FittedLink;

/// The XRDF of `robot` with the spheres of `links`. Those that no controlled joint moves are
/// for self-collision alone. For that all are smaller by what they reach out of their link:
/// links pass each other closer than spheres around their edges would let them.
pub(crate) fn text(robot: &Robot, links: &[FittedLink]) -> String {
    let mut out = String::new();
    let is_moved = |link: &&FittedLink| robot.is_moved(&link.name);
    let (moved, fixed): (Vec<_>, Vec<_>) = links.iter().partition(is_moved);
    // Text into a string does not fail.
    write_all(&mut out, robot, &moved, &fixed, &ignored(robot, links)).unwrap_or_default();
    out
}

fn ignored(robot: &Robot, links: &[FittedLink]) -> BTreeMap<String, Vec<String>> {
    let own = |link: &FittedLink| link.spheres(link.fit.margin).collect::<Vec<_>>();
    let spheres: Vec<CollisionSphere> = links.iter().flat_map(own).collect();
    let mut ignored: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (one, other) in robot.pairs_that_may_touch(&spheres) {
        ignored.entry(one).or_default().push(other);
    }
    ignored
}

fn write_all(
    out: &mut String,
    robot: &Robot,
    moved: &[&FittedLink],
    fixed: &[&FittedLink],
    ignored: &BTreeMap<String, Vec<String>>,
) -> std::fmt::Result {
    let limits = robot.limits();
    writeln!(
        out,
        "# Spheres fitted to the geometry of the URDF by `robocell spheres`. The limits of"
    )?;
    writeln!(
        out,
        "# acceleration and jerk are those of the URDF, or defaults: check them."
    )?;
    writeln!(out, "format: xrdf\nformat_version: 1.0\n")?;
    writeln!(out, "default_joint_positions:")?;
    let names = robot.arm_joint_names();
    for (name, position) in names.iter().zip(&robot.default_joint_positions) {
        writeln!(out, "  {}: {position}", quoted(name))?;
    }
    writeln!(out, "\ncspace:\n  joint_names:")?;
    for name in &names {
        writeln!(out, "    - {}", quoted(name))?;
    }
    writeln!(out, "  acceleration_limits: {:?}", limits.acceleration)?;
    writeln!(out, "  jerk_limits: {:?}\n", limits.jerk)?;
    let tool = quoted(robot.tcp_frame_name());
    writeln!(out, "tool_frames: [{tool}]\n")?;
    writeln!(out, "world_collision:\n  geometry: moved\n")?;
    writeln!(out, "self_collision:\n  geometry: all\n  buffer_distance:")?;
    for link in moved.iter().chain(fixed) {
        // Rounded up, as radii are.
        let less = (link.fit.margin * 1e4).ceil() / 1e4;
        writeln!(out, "    {}: -{less}", quoted(&link.name))?;
    }
    writeln!(
        out,
        "  ignore:{}",
        if ignored.is_empty() { " {}" } else { "" }
    )?;
    for (frame, others) in ignored {
        let others: Vec<String> = others.iter().map(|name| quoted(name)).collect();
        writeln!(out, "    {}: [{}]", quoted(frame), others.join(", "))?;
    }
    writeln!(out, "\ngeometry:\n  moved:")?;
    write_spheres(out, moved)?;
    if fixed.is_empty() {
        return writeln!(out, "  all:\n    clone: moved");
    }
    writeln!(out, "  fixed:")?;
    write_spheres(out, fixed)?;
    writeln!(out, "  all:\n    clone: [moved, fixed]")
}

fn write_spheres(out: &mut String, links: &[&FittedLink]) -> std::fmt::Result {
    if links.is_empty() {
        return writeln!(out, "    spheres: {{}}");
    }
    writeln!(out, "    spheres:")?;
    for link in links {
        writeln!(out, "      {}:", quoted(&link.name))?;
        for (center, radius) in &link.fit.spheres {
            // In steps of 0.1 mm. A radius is rounded up, so that no point becomes uncovered; the
            // addition of 0 turns -0 into 0.
            let [x, y, z] = [center.x, center.y, center.z].map(|x| (x * 1e4).round() / 1e4 + 0.0);
            let radius = (radius * 1e4).ceil() / 1e4;
            writeln!(
                out,
                "        - {{ center: [{x}, {y}, {z}], radius: {radius} }}"
            )?;
        }
    }
    Ok(())
}

/// A name as YAML takes it, whatever it is.
fn quoted(name: &str) -> String {
    let is_plain = name
        .chars()
        .all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.'));
    // YAML 1.1 reads these words as booleans and null.
    let is_word = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && !["true", "false", "null", "yes", "no", "on", "off", "y", "n"]
            .contains(&name.to_ascii_lowercase().as_str());
    if is_plain && is_word {
        name.to_owned()
    } else {
        format!("'{}'", name.replace('\'', "''"))
    }
}

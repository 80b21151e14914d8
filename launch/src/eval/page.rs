//! `robocell eval report --html`: one page that needs nothing beside it.

use std::fmt::Write as _;
use std::path::Path;

use evaluation::charts::{Line, Panel};
use evaluation::report::{Episodes, Report, Reports, episodes};
use evaluation::{EvaluationError, info};

use crate::shell::quoted_word;

/// Failed seeds of a file that are listed.
const LISTED: usize = 1000;
/// Points of a line in a plot.
const POINTS: usize = 500;

const STYLE: &str = "body { font: 15px/1.5 system-ui, sans-serif; max-width: 62em; margin: 2em auto; \
    padding: 0 1em; color: #222 } table { border-collapse: collapse } td, th { text-align: left; \
    padding: .2em .8em .2em 0; border-bottom: 1px solid #ddd; vertical-align: top } \
    code, pre { font-size: 13px } i.bar { display: inline-block; height: .8em; background: #c9302c }";

/// The page of `reports`, whose files are read once more.
pub(super) fn page(reports: &Reports) -> Result<String, EvaluationError> {
    let files = reports.files.iter();
    let read = files.map(|report| Ok((report, episodes(Path::new(&report.file))?)));
    let files = read.collect::<Result<Vec<_>, EvaluationError>>()?;
    let first = reports.files.first();
    let title = first.map_or_else(String::new, |r| format!("{}, policy {}", r.demo, r.policy));
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>{STYLE}</style>\n<h1>{title}</h1>\n",
        title = escape(&title)
    );
    for report in &reports.files {
        let _ok = writeln!(out, "<pre>{}</pre>", escape(&report.to_string()));
    }
    if let Some(comparison) = &reports.comparison {
        let _ok = writeln!(out, "<pre>{}</pre>", escape(&comparison.to_string()));
    }
    out.push_str("<h2>Simulated time of episodes that ended done</h2>\n");
    out.push_str(&times(&files));
    for (report, episodes) in &files {
        reasons(&mut out, report);
        failed(&mut out, report, episodes);
    }
    out.push_str("</html>\n");
    Ok(out)
}

/// Share of all episodes that ended done by a time, over the time.
fn times(files: &[(&Report, Episodes)]) -> String {
    let line = |(report, episodes): &(&Report, Episodes)| {
        let (times, all) = (&episodes.times_s, report.episodes as f64);
        let step = times.len().div_ceil(POINTS).max(1);
        let shown = (1..).zip(times).filter(|(count, _)| count % step == 0);
        let mut points: Vec<_> = shown
            .map(|(count, time): (usize, _)| (*time, 100.0 * count as f64 / all))
            .collect();
        // The last point is always drawn: it shows the share of all episodes that ended done.
        points.extend(
            times
                .last()
                .map(|time| (*time, 100.0 * times.len() as f64 / all)),
        );
        Line {
            name: report.file.clone(),
            points,
        }
    };
    let panel = Panel {
        unit: "% done".to_owned(),
        lines: files.iter().map(line).collect(),
    };
    let ends = panel.lines.iter().flat_map(|line| &line.points);
    let ends: Vec<f64> = ends.map(|(time, _)| *time).collect();
    let first = ends.iter().copied().fold(f64::INFINITY, f64::min);
    let last = ends.iter().copied().fold(0.0, f64::max);
    if ends.is_empty() {
        return "<p>None ended done.</p>\n".to_owned();
    }
    // Equal times have a width, too.
    evaluation::charts::svg(&[panel], ((first - 0.5).max(0.0), last + 0.5))
}

fn reasons(out: &mut String, report: &Report) {
    if report.reasons.is_empty() {
        return;
    }
    let most = report.reasons.values().copied().max().unwrap_or(1);
    let _ok = writeln!(out, "<h2>Why not: {}</h2>\n<table>", escape(&report.file));
    for (reason, count) in &report.reasons {
        let width = 20.0 * *count as f64 / most as f64;
        let reason = escape(reason);
        let _ok = writeln!(
            out,
            "<tr><td>{reason}<td>{count}<td><i class=\"bar\" style=\"width: {width:.2}em\"></i>"
        );
    }
    out.push_str("</table>\n");
}

/// A row for each seed that failed, with the command that runs it again.
fn failed(out: &mut String, report: &Report, episodes: &Episodes) {
    if episodes.failed.is_empty() {
        return;
    }
    let all = episodes.failed.len();
    let _ok = writeln!(out, "<h2>Failed seeds: {}</h2>", escape(&report.file));
    if all > LISTED {
        let _ok = writeln!(out, "<p>The first {LISTED} of {all}.</p>");
    }
    let plan = info::plan_of(Path::new(&report.file));
    if plan.is_none() {
        out.push_str(
            "<p>The side file of the rows is missing, as of merged rows: add the options that \
             <code>robocell eval</code> was given.</p>\n",
        );
    }
    let options = plan.map(|plan| plan.arguments).unwrap_or_default();
    out.push_str("<table>\n<tr><th>seed<th>why<th>after<th>run it again\n");
    for failed in episodes.failed.iter().take(LISTED) {
        let seed = failed.key.seed.to_string();
        let run = ["robocell", "run", &report.demo, "--policy", &report.policy];
        let run = run.into_iter().chain(["--seed", &seed, "--until-done"]);
        let set = failed.settings.iter();
        let set: Vec<String> = set
            .flat_map(|one| ["--set".to_owned(), one.to_string()])
            .collect();
        let given = options.iter().chain(&set).chain(&failed.server);
        let given = given.map(String::as_str);
        let command: Vec<String> = run.chain(given).map(quoted_word).collect();
        let message = failed.message.as_deref().unwrap_or_default();
        // The row of an episode that could not run has its sentence as the reason.
        let more = if failed.reason.contains(message) {
            String::new()
        } else {
            format!("<br>{}", escape(message))
        };
        let _ok = writeln!(
            out,
            "<tr><td>{}<td>{}{more}<td>{:.2} s<td><code>{}</code>",
            failed.key.seed,
            escape(&failed.reason),
            failed.sim_time_s,
            escape(&command.join(" "))
        );
    }
    out.push_str("</table>\n");
}

/// Text as text.
fn escape(text: &str) -> String {
    // `&` first: it is part of the other replacements.
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_for_a_page() {
        assert_eq!(escape("<b a=\"1\">&"), "&lt;b a=&quot;1&quot;&gt;&amp;");
    }
}

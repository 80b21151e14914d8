//! Reports as text.

use std::fmt;

use crate::report::{Comparison, Example, Rate, Report, Times, Variant, Verdict};
use crate::row::Key;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |part: f64| 100.0 * part;
        let Rate { rate, low, high } = self.success;
        writeln!(f, "{}: {}, policy {}", self.file, self.demo, self.policy)?;
        writeln!(
            f,
            "  done        {} of {}: {:.2} % (95 %: {:.2} to {:.2} %)",
            self.done,
            self.episodes,
            percent(rate),
            percent(low),
            percent(high)
        )?;
        for (reason, count) in &self.reasons {
            writeln!(f, "  not done    {count} {reason}")?;
            let example = self.examples.get(reason);
            let message = example.and_then(|one| Some((one, one.message.as_ref()?)));
            // The row of an episode that could not run has its sentence as the reason.
            if let Some((one, message)) = message.filter(|(_, text)| !reason.contains(*text)) {
                let Example { seed, variant, .. } = *one;
                writeln!(f, "              {}: {message}", Key { seed, variant })?;
            }
        }
        if let Some(times) = self.times_s {
            let Times { p50, p90, p99, max } = times;
            writeln!(
                f,
                "  time        p50 {p50:.2} s, p90 {p90:.2} s, p99 {p99:.2} s, max {max:.2} s"
            )?;
        }
        for variant in &self.variants {
            writeln!(f, "  {variant}")?;
        }
        write!(
            f,
            "  drops {}, resyncs {}, aborts {}, limit violations {}",
            self.drops, self.resyncs, self.aborts, self.limit_violations
        )
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Rate { rate, low, high } = self.success;
        for (key, value) in &self.set {
            write!(f, "{key}={value} ")?;
        }
        if let Some(latency_ms) = self.latency_ms {
            write!(f, "latency {latency_ms} ms ")?;
        }
        if let Some(fault) = &self.fault {
            write!(f, "fault {fault} ")?;
        }
        write!(
            f,
            " {} of {}: {:.2} % (95 %: {:.2} to {:.2} %)",
            self.done,
            self.episodes,
            100.0 * rate,
            100.0 * low,
            100.0 * high
        )?;
        match self.times_s {
            Some(times) => write!(f, ", p50 {:.2} s", times.p50),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.pairs > 0 {
            writeln!(
                f,
                "second against first, by {} episodes in both: done in both {}, in the first alone {}, \
                 in the second alone {}, in neither {}",
                self.pairs, self.both, self.first_only, self.second_only, self.neither
            )?;
        } else {
            writeln!(
                f,
                "second against first, as samples that have no episode in common"
            )?;
        }
        write!(f, "  success     {:+.2} %", 100.0 * self.difference)?;
        if let Some((low, high)) = self.interval {
            write!(f, " (95 %: {:+.2} to {:+.2} %)", 100.0 * low, 100.0 * high)?;
        }
        let test = if self.pairs > 0 {
            "McNemar"
        } else {
            "two proportions"
        };
        writeln!(f, ", p = {:.2e} ({test})", self.p)?;
        if let (Some(mean), Some((low, high))) = (self.time_difference_s, self.time_interval_s) {
            writeln!(
                f,
                "  time        {mean:+.3} s (95 %: {low:+.3} to {high:+.3} s), where both are done"
            )?;
        }
        let verdict = match self.verdict {
            Verdict::Better => "the second ends done more often",
            Verdict::Worse => "the second ends done less often",
            Verdict::NoDifference => "no difference in success is shown",
        };
        write!(f, "  verdict     {verdict}")
    }
}

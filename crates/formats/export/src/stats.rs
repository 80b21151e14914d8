//! Statistics of a feature, as trainers normalise by them.

use serde_json::{Value, json};

/// Names and shares of the quantiles.
pub(crate) const QUANTILES: [(&str, f64); 5] = [
    ("q01", 0.01),
    ("q10", 0.10),
    ("q50", 0.50),
    ("q90", 0.90),
    ("q99", 0.99),
];

/// Statistics of the numbers of a feature, in the order of the numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Stats {
    pub(crate) count: usize,
    pub(crate) min: Vec<f64>,
    pub(crate) max: Vec<f64>,
    pub(crate) mean: Vec<f64>,
    pub(crate) std: Vec<f64>,
    pub(crate) quantiles: [Vec<f64>; 5],
}

impl Stats {
    /// Of rows of `width` numbers.
    pub(crate) fn of(numbers: &[f32], width: usize) -> Self {
        let mut stats = Self {
            count: numbers.len() / width.max(1),
            ..Self::default()
        };
        for column in 0..width {
            let values = numbers.iter().skip(column).step_by(width);
            stats.add(values.map(|value| f64::from(*value)).collect());
        }
        stats
    }

    /// Of the channels of `frames` of colour, from 0 to 1; `count` is that of the frames.
    pub(crate) fn of_pictures<'a>(frames: &(impl Iterator<Item = &'a [u8]> + Clone)) -> Self {
        let mut stats = Self {
            count: frames.clone().count(),
            ..Self::default()
        };
        for channel in 0..3 {
            // Millions of values, of which there are 256: they are counted, not sorted.
            let mut counts = [0_usize; 256];
            for value in frames
                .clone()
                .flat_map(|frame| frame.iter().skip(channel).step_by(3))
            {
                if let Some(count) = counts.get_mut(usize::from(*value)) {
                    *count += 1;
                }
            }
            stats.add_counted(&counts);
        }
        stats
    }

    /// Adds a channel by how often each of its values is there.
    fn add_counted(&mut self, counts: &[usize; 256]) {
        let value = |index: usize| index as f64 / 255.0;
        let total = counts.iter().sum::<usize>().max(1);
        let weighted = |of: &dyn Fn(f64) -> f64| {
            let values = counts.iter().enumerate();
            let values = values.map(|(index, count)| *count as f64 * of(value(index)));
            values.sum::<f64>() / total as f64
        };
        let mean = weighted(&|value| value);
        self.mean.push(mean);
        let square = weighted(&|value| (value - mean).powi(2));
        self.std.push(square.sqrt());
        // The value at a place of the sorted values.
        let at = |place: usize| {
            let mut before = 0;
            let index = counts.iter().position(|count| {
                before += count;
                before > place
            });
            value(index.unwrap_or(0))
        };
        self.min.push(at(0));
        self.max.push(at(total - 1));
        for ((_, share), found) in QUANTILES.iter().zip(&mut self.quantiles) {
            found.push(interpolated(*share, total, at));
        }
    }

    /// Adds a number of the feature, with all its values.
    fn add(&mut self, mut values: Vec<f64>) {
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        // In a second pass: the difference of two large squares would lose a small deviation.
        let square = values.iter().map(|value| (value - mean).powi(2));
        self.std.push((square.sum::<f64>() / count).sqrt());
        self.mean.push(mean);
        values.sort_unstable_by(f64::total_cmp);
        self.min.push(values.first().copied().unwrap_or(0.0));
        self.max.push(values.last().copied().unwrap_or(0.0));
        for ((_, share), found) in QUANTILES.iter().zip(&mut self.quantiles) {
            found.push(quantile(&values, *share));
        }
    }

    /// Of all episodes. Quantiles are means, weighted by the counts, as the reference has them.
    pub(crate) fn merged(parts: &[Self]) -> Self {
        let total: f64 = parts.iter().map(|part| part.count as f64).sum();
        let width = parts.first().map_or(0, |part| part.mean.len());
        let mut all = Self {
            count: parts.iter().map(|part| part.count).sum(),
            ..Self::default()
        };
        for at in 0..width {
            let of = |values: &Vec<f64>| values.get(at).copied().unwrap_or(0.0);
            let weighted = |value: &dyn Fn(&Self) -> f64| {
                let parts = parts.iter().map(|part| part.count as f64 * value(part));
                parts.sum::<f64>() / total.max(1.0)
            };
            let mean = weighted(&|part| of(&part.mean));
            let square = weighted(&|part| of(&part.std).powi(2) + of(&part.mean).powi(2));
            all.mean.push(mean);
            // Rounding may make the difference negative, and its root NaN.
            all.std.push((square - mean * mean).max(0.0).sqrt());
            let min = parts.iter().map(|part| of(&part.min));
            all.min.push(min.fold(f64::INFINITY, f64::min));
            let max = parts.iter().map(|part| of(&part.max));
            all.max.push(max.fold(f64::NEG_INFINITY, f64::max));
            for (index, found) in all.quantiles.iter_mut().enumerate() {
                let value = |part: &Self| part.quantiles.get(index).map_or(0.0, of);
                found.push(weighted(&value));
            }
        }
        all
    }

    /// The lists of numbers, by their names.
    pub(crate) fn lists(&self) -> Vec<(&'static str, &[f64])> {
        let mut lists: Vec<(&str, &[f64])> = vec![
            ("min", &self.min),
            ("max", &self.max),
            ("mean", &self.mean),
            ("std", &self.std),
        ];
        let quantiles = QUANTILES.iter().zip(&self.quantiles);
        lists.extend(quantiles.map(|((name, _), values)| (*name, values.as_slice())));
        lists
    }

    /// As in `meta/stats.json`. Those of pictures have the shape (3, 1, 1).
    pub(crate) fn to_json(&self, of_pictures: bool) -> Value {
        let lists = self.lists().into_iter();
        let mut all: serde_json::Map<String, Value> = lists
            .map(|(name, values)| {
                let values = if of_pictures {
                    values.iter().map(|value| json!([[value]])).collect()
                } else {
                    json!(values)
                };
                (name.to_owned(), values)
            })
            .collect();
        all.insert("count".to_owned(), json!([self.count]));
        all.into()
    }
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    interpolated(share, sorted.len(), |place| {
        sorted.get(place).copied().unwrap_or(0.0)
    })
}

/// The value that a share of `count` sorted values is below; `at` gives that of a place.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share of a count is one"
)]
fn interpolated(share: f64, count: usize, at: impl Fn(usize) -> f64) -> f64 {
    let place = share * count.saturating_sub(1) as f64;
    let (below, above) = (at(place.floor() as usize), at(place.ceil() as usize));
    below + (place - place.floor()) * (above - below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_interpolated_and_episodes_weighted() {
        let stats = Stats::of(&[1.0, 10.0, 2.0, 20.0, 4.0, 30.0], 2);
        assert_eq!((stats.count, stats.min[0], stats.max[1]), (3, 1.0, 30.0));
        assert_eq!(stats.quantiles[2], [2.0, 20.0]);
        assert!((stats.quantiles[3][0] - 3.6).abs() < 1e-9);
        let one = Stats::of(&[0.0], 1);
        let counted = Stats::of_pictures(&[[0_u8, 9, 8, 255, 9, 8].as_slice()].into_iter());
        assert_eq!((counted.count, counted.mean[0]), (1, 0.5));
        assert_eq!(
            (counted.min[0], counted.max[0], counted.std[1]),
            (0.0, 1.0, 0.0)
        );
        assert!((counted.quantiles[1][0] - 0.1).abs() < 1e-9);
        let all = Stats::merged(&[one, Stats::of(&[3.0, 3.0], 1)]);
        assert_eq!((all.count, all.mean[0]), (3, 2.0));
        assert!((all.std[0] - 2.0_f64.sqrt()).abs() < 1e-9);
    }
}

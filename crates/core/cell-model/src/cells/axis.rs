//! A number of a cell whose value is searched for, for `eval bisect`.

use serde_json::Number;

use crate::cells::setting::{self, Kind, Setting};
use crate::cells::sweep::Bounds;
use crate::error::ModelError;

/// A number of a cell file, and the bounds within which a value of it is searched for.
#[derive(Clone, Debug)]
pub struct Axis {
    bounds: Bounds,
    kind: Kind,
}

impl Axis {
    /// The number with the key of `bounds` in a cell file with this text.
    ///
    /// # Errors
    /// Returns [`ModelError`] for a key that is not the path of a number.
    pub fn new(bounds: Bounds, file: &str, text: &str) -> Result<Self, ModelError> {
        let places = setting::places(file, text, &bounds.key)?;
        let is_integer = places.iter().any(|place| place.kind == Kind::Integer);
        let kind = if is_integer {
            Kind::Integer
        } else {
            Kind::Float
        };
        Ok(Self { bounds, kind })
    }

    /// The smallest and the largest value.
    pub fn ends(&self) -> [Number; 2] {
        [self.bounds.low.clone(), self.bounds.high.clone()]
    }

    /// The setting that gives the number this value.
    pub fn at(&self, value: &Number) -> Setting {
        Setting {
            key: self.bounds.key.clone(),
            value: value.clone(),
        }
    }

    /// The value in the middle of `low` and `high`; `None` if there is none between them.
    pub fn middle(&self, low: &Number, high: &Number) -> Option<Number> {
        let between = Bounds {
            key: String::new(),
            low: low.clone(),
            high: high.clone(),
        };
        // An integer of the file stays one: a cell refuses 4.5 for it.
        let middle = match between.integers().filter(|_| self.kind == Kind::Integer) {
            Some((low, high)) => Number::from(low.midpoint(high)),
            None => Number::from_f64(low.as_f64()?.midpoint(high.as_f64()?))?,
        };
        // Adjacent values end the search; halving again would never end.
        (middle != *low && middle != *high).then_some(middle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[[object]]\nname = \"red\"\nmass = 1.0\n[task]\nattempts = 3\n";

    #[test]
    fn an_axis_is_halved_until_nothing_is_between() {
        let of = |text: &str| Axis::new(text.parse().unwrap(), "c.toml", TEXT).unwrap();
        let number = |text: &str| setting::number(text).unwrap();
        let middle = |axis: &Axis, low: &str, high: &str| {
            let middle = axis.middle(&number(low), &number(high));
            middle.map(|middle| middle.to_string())
        };
        let attempts = of("task.attempts=1..8");
        assert_eq!(middle(&attempts, "1", "8").as_deref(), Some("4"));
        assert_eq!(middle(&attempts, "4", "5"), None);
        let mass = of("object.red.mass=1..2");
        assert_eq!(middle(&mass, "1", "2").as_deref(), Some("1.5"));
        assert_eq!(mass.at(&number("1.5")).to_string(), "object.red.mass=1.5");
        let next = 1.0_f64.next_up().to_string();
        assert_eq!(middle(&mass, "1.0", &next), None);
    }
}

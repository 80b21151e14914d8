//! The pace of simulated time.

use serde::{Deserialize, Serialize};

/// The pace of simulated time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Speed {
    /// One tick each millisecond; late messages are late.
    #[default]
    RealTime,
    /// Lockstep at the largest speed: physics waits for every process.
    Max,
    /// Lockstep, paced at this multiple of real time.
    Factor(f64),
}

impl Speed {
    /// Whether physics waits for every process.
    pub fn is_lockstep(self) -> bool {
        self != Self::RealTime
    }

    /// Simulated seconds per second; 0 for the largest speed.
    pub fn factor(self) -> f64 {
        match self {
            Self::RealTime => 1.0,
            Self::Max => 0.0,
            Self::Factor(factor) => factor,
        }
    }

    /// The speed with this [`Self::factor`], if it is allowed.
    pub fn of_factor(factor: f64) -> Option<Self> {
        match factor {
            0.0 => Some(Self::Max),
            1.0 => Some(Self::RealTime),
            _ if (0.01..=50.0).contains(&factor) => Some(Self::Factor(factor)),
            _ => None,
        }
    }
}

impl std::str::FromStr for Speed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "1" => Ok(Self::RealTime),
            "max" => Ok(Self::Max),
            _ => match text.parse::<f64>() {
                // `1.0` is real time, too: as a factor it would be lockstep at the same pace.
                Ok(1.0) => Ok(Self::RealTime),
                Ok(factor) if (0.01..=50.0).contains(&factor) => Ok(Self::Factor(factor)),
                _ => Err(format!(
                    "speed is {text:?}; allowed are 1 (real time), max, or a factor from 0.01 to 50"
                )),
            },
        }
    }
}

//! `[task.place.NAME]`: a place where objects belong.

use cell_model::check::MAX_COORDINATE_M;
use cell_model::{Checker, ModelError};
use nalgebra::Vector2;
use robocell_task::job::Placement;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::geometry;

/// Largest number of slots of a place: the occupied ones are a mask of 64 bits.
const MAX_SLOTS: u32 = 64;

/// A place where objects belong: one slot, or a pattern of slots.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceTable {
    /// Point of the surface below the centre of the first object, world frame
    /// (m).
    pub position_m: [f64; 3],
    /// Turn of the objects and of the pattern about the vertical axis (rad).
    #[serde(default)]
    pub yaw_rad: f64,
    /// More slots than one.
    #[serde(default)]
    pub pattern: Option<Pattern>,
}

/// An arrangement of slots. Slots are filled in the order given here.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Pattern {
    /// One on top of the other.
    Stack {
        /// Objects.
        layers: u32,
        /// Height of one layer (m).
        layer_height_m: f64,
    },
    /// Side by side, row by row, layer by layer, beginning at `position_m`.
    Grid {
        /// Objects along x, along y and upwards.
        count: [u32; 3],
        /// Distance of neighbours along x, along y and upwards (m).
        pitch_m: [f64; 3],
        /// Order of the slots, by their numbers from 0 up in the default order;
        /// the default order where it is missing.
        #[serde(default)]
        order: Option<Vec<u32>>,
    },
    /// A row of objects along y, centred on `position_m`, on it a row with one
    /// less, and so on.
    Pyramid {
        /// Objects of the lowest row.
        base: u32,
        /// Distance of neighbours (m).
        pitch_m: f64,
        /// Height of one layer (m).
        layer_height_m: f64,
    },
}

impl PlaceTable {
    /// By slot: the point of the surface below the object's centre (m) and the object's turn
    /// (rad), world frame.
    pub(crate) fn slots(&self) -> Vec<Placement> {
        let along = |offset: [f64; 3]| {
            let plane = geometry::turned(Vector2::new(offset[0], offset[1]), self.yaw_rad);
            let [x, y, z] = self.position_m;
            Placement {
                position: [x + plane.x, y + plane.y, z + offset[2]],
                yaw: self.yaw_rad,
            }
        };
        self.offsets().into_iter().map(along).collect()
    }

    /// By slot: its offset from the first position in the frame of the place (m).
    fn offsets(&self) -> Vec<[f64; 3]> {
        match &self.pattern {
            None => vec![[0.0; 3]],
            Some(Pattern::Stack {
                layers,
                layer_height_m,
            }) => (0..*layers)
                .map(|layer| [0.0, 0.0, f64::from(layer) * layer_height_m])
                .collect(),
            Some(Pattern::Grid {
                count,
                pitch_m,
                order,
            }) => grid(*count, *pitch_m, order.as_deref()),
            Some(Pattern::Pyramid {
                base,
                pitch_m,
                layer_height_m,
            }) => pyramid(*base, *pitch_m, *layer_height_m),
        }
    }

    pub(super) fn check(&self, at: &Checker<'_>, key: &str) -> Result<(), ModelError> {
        at.position(&format!("{key}.position_m"), &self.position_m)?;
        at.number(&format!("{key}.yaw_rad"), self.yaw_rad, -7.0, 7.0)?;
        let key = format!("{key}.pattern");
        let (count, lengths) = match &self.pattern {
            None => return Ok(()),
            Some(Pattern::Stack {
                layers,
                layer_height_m,
            }) => (*layers, vec![*layer_height_m]),
            Some(Pattern::Grid {
                count: [x, y, z],
                pitch_m,
                order,
            }) => {
                let count = x.saturating_mul(*y).saturating_mul(*z);
                check_order(at, &key, order.as_deref(), count)?;
                (count, pitch_m.to_vec())
            }
            Some(Pattern::Pyramid {
                base,
                pitch_m,
                layer_height_m,
            }) => (
                base.saturating_mul(base.saturating_add(1)) / 2,
                vec![*pitch_m, *layer_height_m],
            ),
        };
        if count == 0 || count > MAX_SLOTS {
            let allowed = format!("1 to {MAX_SLOTS} are allowed");
            return Err(at.refuse(&key, format!("of {count} slots"), allowed));
        }
        at.numbers(&key, &lengths, -MAX_COORDINATE_M, MAX_COORDINATE_M)
    }
}

fn check_order(
    at: &Checker<'_>,
    key: &str,
    order: Option<&[u32]>,
    count: u32,
) -> Result<(), ModelError> {
    let Some(order) = order else { return Ok(()) };
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    // A number that is missing would be a slot that is never filled.
    if sorted.iter().copied().eq(0..count.min(MAX_SLOTS)) {
        return Ok(());
    }
    let allowed = format!("each number from 0 to {} is needed once", count.max(1) - 1);
    Err(at.refuse(&format!("{key}.order"), format!("{order:?}"), allowed))
}

fn grid(count: [u32; 3], pitch: [f64; 3], order: Option<&[u32]>) -> Vec<[f64; 3]> {
    let [nx, ny, nz] = count;
    let mut all = Vec::new();
    for z in 0..nz.min(MAX_SLOTS) {
        for y in 0..ny.min(MAX_SLOTS) {
            for x in 0..nx.min(MAX_SLOTS) {
                let index = [x, y, z].map(f64::from);
                all.push([0, 1, 2].map(|axis: usize| index[axis] * pitch[axis]));
            }
        }
    }
    match order {
        None => all,
        Some(order) => {
            let slot = |number: &u32| all.get(*number as usize).copied();
            order.iter().filter_map(slot).collect()
        }
    }
}

fn pyramid(base: u32, pitch: f64, layer: f64) -> Vec<[f64; 3]> {
    let base = base.min(MAX_SLOTS);
    let mut all = Vec::new();
    for row in 0..base {
        let width = base - row;
        for index in 0..width {
            let along = f64::from(index) - 0.5 * f64::from(width - 1);
            all.push([0.0, along * pitch, f64::from(row) * layer]);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(pattern: Pattern) -> PlaceTable {
        PlaceTable {
            position_m: [0.0; 3],
            yaw_rad: 0.0,
            pattern: Some(pattern),
        }
    }

    #[test]
    fn a_pattern_is_filled_from_below() {
        let stack = table(Pattern::Stack {
            layers: 3,
            layer_height_m: 0.05,
        });
        assert_eq!(stack.offsets()[2], [0.0, 0.0, 0.1]);
        let pyramid = table(Pattern::Pyramid {
            base: 3,
            pitch_m: 0.06,
            layer_height_m: 0.05,
        });
        let offsets = pyramid.offsets();
        assert_eq!(offsets.len(), 6);
        assert_eq!(
            (offsets[0], offsets[5]),
            ([0.0, -0.06, 0.0], [0.0, 0.0, 0.1])
        );
        assert!(offsets.windows(2).all(|pair| pair[0][2] <= pair[1][2]));
    }

    #[test]
    fn a_grid_is_filled_in_the_order_of_the_file() {
        let grid = |order| {
            table(Pattern::Grid {
                count: [2, 2, 1],
                pitch_m: [0.1, 0.2, 0.0],
                order,
            })
        };
        assert_eq!(grid(None).offsets()[1], [0.1, 0.0, 0.0]);
        let turned = grid(Some(vec![3, 2, 1, 0]));
        assert_eq!(turned.offsets()[0], [0.1, 0.2, 0.0]);
        let at = Checker::new("a.toml", "");
        assert!(turned.check(&at, "task.place.a").is_ok());
        let twice = grid(Some(vec![0, 1, 1, 2])).check(&at, "task.place.a");
        assert!(twice.unwrap_err().to_string().contains("0 to 3"));
    }

    #[test]
    fn an_endless_pattern_is_refused() {
        let at = Checker::new("a.toml", "");
        let huge = table(Pattern::Grid {
            count: [u32::MAX; 3],
            pitch_m: [0.1; 3],
            order: None,
        });
        assert!(huge.check(&at, "task.place.a").is_err());
        assert!(huge.offsets().len() <= (MAX_SLOTS as usize).pow(3));
    }
}

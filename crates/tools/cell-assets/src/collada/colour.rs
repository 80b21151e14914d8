//! From the symbol of a primitive to its diffuse colour.

use std::collections::HashMap;

use roxmltree::Node;

use super::{Child, Result, geometry};

/// Colour of a material that has none, sRGB.
const GREY: [f32; 3] = [0.6, 0.6, 0.6];

/// Materials bound at one instance of a geometry.
pub(super) struct Colours<'a> {
    targets: HashMap<&'a str, &'a str>,
}

impl<'a> Colours<'a> {
    pub(super) fn of(instance: Node<'a, '_>) -> Self {
        let bound = instance
            .descendants()
            .filter(|node| node.has_tag_name_any("instance_material"));
        let targets = bound.filter_map(|node| {
            let target = node.attribute("target")?;
            Some((node.attribute("symbol")?, target.trim_start_matches('#')))
        });
        Self {
            targets: targets.collect(),
        }
    }

    /// Diffuse colour of a symbol; grey where the file gives none.
    pub(super) fn diffuse(
        &self,
        symbol: &str,
        ids: &HashMap<&str, Node<'_, '_>>,
    ) -> Result<[f32; 3]> {
        let material = self.targets.get(symbol).and_then(|id| ids.get(id));
        let effect = material
            .and_then(|m| m.child("instance_effect"))
            .and_then(|e| e.attribute("url"))
            .and_then(|url| ids.get(url.trim_start_matches('#')));
        let diffuse = effect.and_then(|e| e.descendants().find(|n| n.has_tag_name_any("diffuse")));
        let Some(colour) = diffuse.and_then(|d| d.child("color")) else {
            return Ok(GREY);
        };
        let values = geometry::numbers(colour)?;
        let [r, g, b, ..] = values[..] else {
            let line = geometry::line(colour);
            return Err(format!(
                "line {line}: a colour of {} numbers, needed are 3",
                values.len()
            ));
        };
        #[expect(clippy::cast_possible_truncation, reason = "colours are coarse")]
        Ok([r, g, b].map(|c| c.clamp(0.0, 1.0) as f32))
    }
}

/// Colours that look alike have the same key.
pub(super) fn key(colour: [f32; 3]) -> [u8; 3] {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to 0 to 1"
    )]
    colour.map(|c| (c * 255.0).round() as u8)
}

//! A picture: the nearest surfaces and their light.

use crate::Picture;
use crate::cast::LANES;
use crate::light::Light;
use crate::nearest::{index_of, nearest};
use crate::scene::Scene;
use crate::shade::shade;
use crate::view::View;

/// Draws what `view` sees of `scene`.
pub fn draw(scene: &Scene, view: &View, light: &Light) -> Picture {
    let nearest = nearest(scene, view);
    let (width, height) = (view.width as usize, view.height as usize);
    let rgb = shade(scene, view, light, &nearest);
    let mut depth_m = Vec::with_capacity(width * height);
    let mut mask = Vec::with_capacity(width * height);
    for row in 0..height {
        let groups = row * nearest.groups..(row + 1) * nearest.groups;
        let pixels = nearest.depth[groups.clone()]
            .iter()
            .zip(&nearest.body[groups]);
        let pixels = pixels.flat_map(|(depth, body)| {
            let (depth, body) = (depth.to_array(), body.to_array());
            (0..LANES).map(move |lane| (depth[lane], body[lane]))
        });
        // The last group of a row may have lanes beyond the edge of the picture.
        for (depth, body) in pixels.take(width) {
            let seen = index_of(depth, body).and_then(|index| scene.bodies.get(index));
            depth_m.push(if seen.is_some() { depth } else { 0.0 });
            mask.push(seen.map_or(0, |body| body.instance));
        }
    }
    Picture {
        width: view.width,
        height: view.height,
        rgb,
        depth_m,
        mask,
    }
}

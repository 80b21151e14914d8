//! Light barriers: rays that objects interrupt.

use cell_model::cells::cell::SensorTable;
use ipc_types::equipment::MAX_SENSORS;
use nalgebra::Vector3;
use parry3d_f64::query::Ray;
use rapier3d_f64::prelude::*;

use crate::engine::convert;
use crate::engine::simulation::Engine;

/// A light barrier.
pub(crate) struct Sensor {
    start: Vector3<f64>,
    /// Unit vector.
    direction: Vector3<f64>,
    range: f64,
}

impl Sensor {
    /// As in the cell file, which was checked to have a direction that is not zero.
    pub(crate) fn new(table: &SensorTable) -> Self {
        let direction = Vector3::from(table.direction);
        Self {
            start: Vector3::from(table.position_m),
            direction: direction / direction.norm(),
            range: table.range_m,
        }
    }

    /// Whether the distance of the ray from `centre` is at most `radius`.
    fn comes_near(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        let along = (centre - self.start)
            .dot(&self.direction)
            .clamp(0.0, self.range);
        let nearest = self.start + self.direction * along;
        (centre - nearest).norm_squared() <= radius * radius
    }

    fn distance(&self, engine: &PhysicsWorld, body: &RigidBody) -> Option<f64> {
        let ray = Ray::new(
            convert::to_vector(&self.start),
            convert::to_vector(&self.direction),
        );
        let hits = body.colliders().iter().filter_map(|handle| {
            let collider = engine.colliders.get(*handle)?;
            let shape = collider.shape();
            shape.cast_ray(collider.position(), &ray, self.range, true)
        });
        hits.min_by(f64::total_cmp)
    }
}

/// By sensor: the object that interrupts it, plus 1.
pub(crate) fn read(sensors: &[Sensor], engine: &Engine) -> [u32; MAX_SENSORS] {
    let mut out = [0; MAX_SENSORS];
    for (number, sensor) in out.iter_mut().zip(sensors) {
        let nearest = sensor.interrupted_by(engine);
        *number = nearest.map_or(0, |object| u32::try_from(object + 1).unwrap_or(0));
    }
    out
}

impl Sensor {
    fn interrupted_by(&self, engine: &Engine) -> Option<usize> {
        let hits = engine
            .specs()
            .iter()
            .enumerate()
            .filter_map(|(index, spec)| {
                let body = engine.object(index)?;
                let centre = convert::from_vector(body.translation());
                // The bounding sphere first: a ray is cast only against objects near it.
                let may =
                    body.is_enabled() && self.comes_near(&centre, spec.shape.bounding_radius());
                let distance = may.then(|| self.distance(engine.rapier(), body))??;
                Some((index, distance))
            });
        let nearest = hits.min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map(|(index, _)| index)
    }
}

//! A state that was read back continues to the bit, also with what rolls in it.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::scene::{FRICTION, Running, Scene, about, box_of, capsule, cylinder, lying};

fn rolling() -> Running {
    let mut scene = Scene::new(false);
    let tilt = about(Vector3::y_axis(), 4.0);
    let slope = Isometry3::from_parts(Translation3::new(0.0, 0.0, 0.3), tilt);
    scene.fixture("slope", box_of([1.0, 1.0, 0.1]), slope, FRICTION);
    let across = about(Vector3::z_axis(), 70.0) * lying();
    for (shape, aside) in [(cylinder(), -0.2), (capsule(), 0.2)] {
        let start = slope * Translation3::new(-0.3, aside, 0.07) * across;
        scene.object(shape, 0.1, start);
    }
    scene.start()
}

#[test]
fn a_restored_and_a_reset_scene_roll_on_to_the_bit() {
    let mut one = rolling();
    let initial = one.world.snapshot();
    one.run(0.3);
    let mut restored = rolling();
    restored.world.restore(&one.world.snapshot()).unwrap();
    for _ in 0..500 {
        one.run(1.0e-3);
        restored.run(1.0e-3);
        assert_eq!(one.state(), restored.state());
    }
    // From its first state it takes the same way again.
    let end = one.state().state_hash;
    one.world.restore(&initial).unwrap();
    one.run(0.8);
    assert_eq!(one.state().state_hash, end);
    // A reset keeps the tick; the places are those of the first time.
    let places = [one.place(0), one.place(1)];
    one.world.reset().unwrap();
    one.run(0.8);
    assert_eq!([one.place(0), one.place(1)], places);
}

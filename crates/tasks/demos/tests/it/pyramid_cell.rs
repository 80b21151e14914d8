//! The cell of the pyramid and its `[task]` belong together.

use cell_model::{Cell, Data};
use demos::pyramid::numbers::PyramidTask;

#[test]
fn the_pyramid_demo_has_two_arms_with_a_part_each() {
    let cell = Cell::load(&Data::checkout(), "franka-pyramid", 3, None).unwrap();
    let task: PyramidTask = cell.task.read().unwrap();
    assert_eq!(cell.objects.len(), 6);
    for (arm, side) in cell.arms.iter().zip([-1.0, 1.0]) {
        let part = &task.robot[&arm.name];
        assert!(part.goal_m[1] * side > 0.0, "each on its own side");
        assert!(
            part.order
                .iter()
                .all(|name| cell.object_index(name).is_ok())
        );
        // Its stack and the whole pyramid are within reach.
        let base = arm.base.translation.vector.xy();
        let goal = nalgebra::Vector2::from(part.goal_m);
        assert!((goal - base).norm() < task.reach_m);
        for object in &cell.objects {
            assert!((object.pose.translation.vector.xy() - base).norm() < task.reach_m);
        }
    }
}

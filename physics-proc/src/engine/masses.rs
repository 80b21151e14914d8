//! Objects whose masses are too far apart for one to carry the other.

use cell_model::Cell;

/// Largest ratio of masses that contacts carry properly. Contacts are springs whose stiffness
/// follows the lighter body: the depth is 5 um per unit of the ratio, 1 mm at 200. From 500 on
/// a load on a small box falls over, at 2000 it sinks through.
const CARRIED: f64 = 200.0;

/// The two objects whose masses are furthest apart, where one cannot carry the other.
pub(crate) fn warning(cell: &Cell) -> Option<String> {
    let by_mass =
        |a: &&cell_model::ObjectSpec, b: &&cell_model::ObjectSpec| a.mass.total_cmp(&b.mass);
    let light = cell.objects.iter().min_by(by_mass)?;
    let heavy = cell.objects.iter().max_by(by_mass)?;
    let ratio = heavy.mass / light.mass;
    // A warning, not an error: the two may never touch.
    (ratio > CARRIED).then(|| {
        format!(
            "object '{}' ({} kg) is {ratio:.0} times as heavy as object '{}' ({} kg): one that \
             carries another of more than {CARRIED} times its mass is pressed in or passed \
             through; let their masses differ less if they touch",
            heavy.name, heavy.mass, light.name, light.mass
        )
    })
}

#[cfg(test)]
mod tests {
    use cell_model::Data;

    use super::*;

    #[test]
    fn masses_too_far_apart_are_named_and_those_of_the_demos_are_not() {
        let mut cell = Cell::load(&Data::checkout(), "franka-stack", 1, None).unwrap();
        assert_eq!(warning(&cell), None);
        (cell.objects[1].mass, cell.objects[2].mass) = (10.0, 0.05);
        assert_eq!(warning(&cell), None);
        cell.objects[1].mass = 50.0;
        let said = warning(&cell).unwrap();
        let (heavy, light) = (&cell.objects[1].name, &cell.objects[2].name);
        for part in [heavy.as_str(), light, "(50 kg)", "(0.05 kg)", "1000 times"] {
            assert!(said.contains(part), "{said}");
        }
    }
}

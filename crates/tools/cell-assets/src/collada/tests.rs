use super::*;
use crate::glb;
use crate::normals::shade;

/// A square as one polygon, and a triangle of another colour, in centimetres,
/// under a node that lifts them by 100 of these.
const SQUARE: &str = r##"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_effects>
 <effect id="red-fx"><profile_COMMON><technique sid="c"><lambert><diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="red"><instance_effect url="#red-fx"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
 <source id="p"><float_array id="pa" count="12">0 0 0  10 0 0  10 10 0  0 10 0</float_array>
  <technique_common><accessor source="#pa" count="4" stride="3"/></technique_common></source>
 <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
 <polylist material="one" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
  <input semantic="NORMAL" source="#n" offset="1"/><vcount>4</vcount><p>0 0 1 0 2 0 3 0</p></polylist>
 <triangles material="two" count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">
 <node id="light"><matrix>1 0 0 7 0 1 0 7 0 0 1 7 0 0 0 1</matrix><instance_light url="#l"/></node>
 <node><translate>0 0 100</translate><rotate>0 0 1 90</rotate>
  <instance_geometry url="#g"><bind_material><technique_common>
   <instance_material symbol="one" target="#red"/></technique_common></bind_material></instance_geometry></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##;

#[test]
fn units_nodes_and_colours_are_applied() {
    let meshes = read("square.dae", SQUARE).unwrap();
    let [grey, red] = &meshes[..] else {
        panic!("{meshes:?}");
    };
    assert_eq!(grey.triangles, [[0, 1, 2]]);
    assert_eq!(red.colour, [1.0, 0.0, 0.0]);
    assert_eq!(red.triangles, [[0, 1, 2], [0, 2, 3]]);
    let corner = red.positions[1];
    let expected = [0.0, 0.1, 1.0];
    assert!(
        corner
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-12),
        "{corner:?}"
    );
}

#[test]
fn a_file_becomes_a_gltf_file() {
    let meshes = read("square.dae", SQUARE).unwrap();
    let shaded: Vec<_> = meshes.iter().map(|mesh| shade(&mesh.welded())).collect();
    let bytes = glb::write("square", &shaded).unwrap();
    let back = glb::tests::parse(&bytes);
    assert_eq!(back.len(), 2);
    assert_eq!(back[1].indices.len(), 6);
    assert_eq!(back[1].positions.len(), 4);
    assert!(back[1].normals.iter().all(|n| *n == [0.0, 0.0, 1.0]));
    assert_eq!(back, shaded);
}

#[test]
fn a_mirror_keeps_the_outside_outside() {
    let mirrored = SQUARE.replace("<rotate>0 0 1 90</rotate>", "<scale>-1 1 1</scale>");
    let meshes = read("square.dae", &mirrored).unwrap();
    let shaded = shade(&meshes[1].welded());
    assert!(
        shaded.normals.iter().all(|n| n[2] == 1.0),
        "{:?}",
        shaded.normals
    );
}

#[test]
fn what_is_wrong_is_named_with_file_and_line() {
    let wrong = [
        ("Z_UP", "Y_UP", "up_axis is Y_UP"),
        (
            "meter=\"0.01\"",
            "meter=\"0\"",
            "allowed are numbers above 0",
        ),
        ("10 10 0", "10 NaN 0", "line 9: `NaN`"),
        ("0 1 2<", "0 1 4<", "line 14: point 4, there are 4"),
        ("<vcount>4<", "<vcount>5<", "line 13"),
        (
            "url=\"#g\"",
            "url=\"#h\"",
            "line 19: nothing has the id `h`",
        ),
        (
            "instance_light",
            "instance_node",
            "instance_node is not supported",
        ),
        ("COLLADA>", "COLLADA", "unexpected end"),
    ];
    for (old, new, expected) in wrong {
        let text = SQUARE.replace(old, new);
        let said = read("square.dae", &text).unwrap_err().to_string();
        assert!(
            said.contains("square.dae") && said.contains(expected),
            "{new}: {said}"
        );
    }
}

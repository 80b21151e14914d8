//! What a user sees of `robocell spheres`.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use cell_assets::spheres::{Fitted, Packages, Rules, SphereError, fit_robot};
use cell_model::{Robot, RobotFiles};
use nalgebra::Point3;
use tempfile::TempDir;

const RULES: Rules = Rules {
    margin: 0.015,
    most: 16,
};

/// Corners of a ring of `radius` at the height `z`.
fn ring(radius: f64, z: f64) -> Vec<[f64; 3]> {
    let angles = (0..24).map(|n| f64::from(n) * std::f64::consts::TAU / 24.0);
    angles
        .map(|angle| [radius * angle.cos(), radius * angle.sin(), z])
        .collect()
}

/// A tube without ends, as many meshes of links are: radius 50 mm, 0.4 m long.
fn tube() -> Vec<[[f64; 3]; 3]> {
    let (low, high) = (ring(0.05, 0.0), ring(0.05, 0.4));
    (0..24)
        .flat_map(|n| {
            let next = (n + 1) % 24;
            [
                [low[n], low[next], high[n]],
                [high[n], low[next], high[next]],
            ]
        })
        .collect()
}

#[expect(clippy::cast_possible_truncation, reason = "the format has 32 bits")]
fn binary_stl(triangles: &[[[f64; 3]; 3]], scale: f64) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    // The first word of an STL in text, which some programs write into binary files.
    bytes[..5].copy_from_slice(b"solid");
    bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        for x in triangle.iter().flatten() {
            bytes.extend(((x * scale) as f32).to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj(triangles: &[[[f64; 3]; 3]]) -> String {
    let mut text = String::from("mtllib missing.mtl\n");
    for [x, y, z] in triangles.iter().flatten() {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for n in 0..triangles.len() {
        writeln!(text, "f {} {} {}", 3 * n + 1, 3 * n + 2, 3 * n + 3).unwrap();
    }
    text
}

fn dae(triangles: &[[[f64; 3]; 3]], up: &str) -> String {
    let numbers: Vec<String> = triangles
        .iter()
        .flatten()
        .flatten()
        .map(f64::to_string)
        .collect();
    let corners: Vec<String> = (0..3 * triangles.len()).map(|n| n.to_string()).collect();
    format!(
        "<COLLADA><asset><unit meter='1'/><up_axis>{up}</up_axis></asset><library_geometries>\
         <geometry id='g'><mesh><source id='p'><float_array id='a' count='{0}'>{1}</float_array>\
         <technique_common><accessor source='#a' count='{2}' stride='3'/></technique_common>\
         </source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices>\
         <triangles count='{3}'><input semantic='VERTEX' source='#v' offset='0'/><p>{4}</p>\
         </triangles></mesh></geometry></library_geometries><library_visual_scenes>\
         <visual_scene id='s'><node><instance_geometry url='#g'/></node></visual_scene>\
         </library_visual_scenes><scene><instance_visual_scene url='#s'/></scene></COLLADA>",
        numbers.len(),
        numbers.join(" "),
        numbers.len() / 3,
        triangles.len(),
        corners.join(" ")
    )
}

/// An arm with two joints, whose upper arm is `geometry`.
fn urdf(dir: &Path, geometry: &str) -> PathBuf {
    let text = format!(
        "<robot name='own'>\n\
         <link name='base'><collision><origin xyz='0 0 0.05'/>\
         <geometry><box size='0.2 0.2 0.1'/></geometry></collision></link>\n\
         <link name='on: arm'><inertial><mass value='2'/>\
         <inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial>\
         <collision>\n<geometry>{geometry}</geometry></collision></link>\n\
         <link name='hand'><visual><geometry><sphere radius='0.04'/></geometry></visual></link>\n\
         <joint name='j1' type='revolute'><parent link='base'/><child link='on: arm'/>\
         <origin xyz='0 0 0.12'/><axis xyz='0 1 0'/>\
         <limit lower='-2' upper='2' effort='50' velocity='1'/></joint>\n\
         <joint name='j2' type='revolute'><parent link='on: arm'/><child link='hand'/>\
         <origin xyz='0 0 0.45'/><axis xyz='0 1 0'/>\
         <limit lower='-2' upper='2' effort='50' velocity='1'/></joint>\n\
         </robot>\n"
    );
    let path = dir.join("own.urdf");
    fs::write(&path, text).unwrap();
    path
}

fn fit(dir: &Path, geometry: &str, packages: &Packages) -> Result<Fitted, SphereError> {
    let urdf = urdf(dir, geometry);
    let files = RobotFiles {
        urdf,
        ..RobotFiles::default()
    };
    fit_robot(&files, packages, RULES)
}

/// Every point of the tube is in a sphere, and no sphere reaches far out of it.
fn assert_covers_the_tube(fitted: &Fitted) {
    let arm = &fitted.links[1];
    assert_eq!(arm.name, "on: arm");
    let spheres = &arm.fit.spheres;
    assert!((3..=16).contains(&spheres.len()), "{}", spheres.len());
    for height in 0..=40 {
        for [x, y, z] in ring(0.05, 0.01 * f64::from(height)) {
            let point = Point3::new(x, y, z);
            let inside = |(center, radius): &(Point3<f64>, f64)| (center - point).norm() <= *radius;
            assert!(spheres.iter().any(inside), "{point}");
        }
    }
    for (center, radius) in spheres {
        let across = center.x.hypot(center.y) + radius;
        assert!(across <= 0.05 + arm.fit.margin + 1e-3, "{across}");
        let (low, high) = (center.z - radius, center.z + radius);
        assert!(low > -0.06 && high < 0.46, "{low} to {high}");
    }
    assert!(arm.fit.margin < 0.03, "{}", arm.fit.margin);
}

#[test]
fn meshes_of_all_kinds_are_covered_and_the_robot_runs_with_the_file() {
    let dir = TempDir::new().unwrap();
    let packages = Packages::default();
    let named = |file: &str| format!("<mesh filename='meshes/{file}'/>");
    fs::create_dir(dir.path().join("meshes")).unwrap();
    let write = |file: &str, bytes: &[u8]| fs::write(dir.path().join("meshes").join(file), bytes);
    write("tube.stl", &binary_stl(&tube(), 1.0)).unwrap();
    write("tube.obj", obj(&tube()).as_bytes()).unwrap();
    write("tube.dae", dae(&tube(), "Y_UP").as_bytes()).unwrap();
    write("mm.STL", &binary_stl(&tube(), 1000.0)).unwrap();
    let millimetres = "<mesh filename='meshes/mm.STL' scale='0.001 0.001 0.001'/>".to_owned();
    for geometry in [
        named("tube.stl"),
        named("tube.obj"),
        named("tube.dae"),
        millimetres,
    ] {
        let fitted = fit(dir.path(), &geometry, &packages).unwrap();
        assert_covers_the_tube(&fitted);
        let xrdf = dir.path().join("own.xrdf");
        fs::write(&xrdf, &fitted.xrdf).unwrap();
        let robot = Robot::from_files(&RobotFiles {
            urdf: dir.path().join("own.urdf"),
            xrdf: Some(xrdf),
            ..RobotFiles::default()
        })
        .unwrap_or_else(|error| panic!("{error}\n{}", fitted.xrdf));
        // What does not move cannot keep away from the world.
        assert!(robot.spheres.iter().all(|sphere| sphere.frame != "base"));
        assert!(
            robot
                .self_spheres
                .iter()
                .any(|sphere| sphere.frame == "base")
        );
        let ignored = |a: &str, b: &str| {
            let mut pairs = robot.self_ignore.iter();
            pairs.any(|(x, y)| (x == a && y == b) || (x == b && y == a))
        };
        assert!(ignored("base", "on: arm"), "neighbours");
    }
}

#[test]
fn a_link_without_collision_geometry_has_spheres_of_its_visual() {
    let dir = TempDir::new().unwrap();
    let cylinder = "<cylinder radius='0.05' length='0.4'/>";
    let fitted = fit(dir.path(), cylinder, &Packages::default()).unwrap();
    let seen: Vec<_> = fitted
        .links
        .iter()
        .map(|link| (link.name.as_str(), link.is_visual))
        .collect();
    assert_eq!(seen, [("base", false), ("on: arm", false), ("hand", true)]);
    let spheres = &fitted.links[1].fit.spheres;
    assert!(
        spheres.iter().all(|(center, _)| center.z.abs() < 0.22),
        "along z"
    );
    assert_eq!(fitted.links[2].fit.spheres.len(), 1, "a ball");
}

#[test]
fn packages_are_found_beside_the_urdf_by_name_and_by_the_environment() {
    let dir = TempDir::new().unwrap();
    let uri = "<mesh filename='package://own_description/meshes/tube.stl'/>";
    let missing = fit(dir.path(), uri, &Packages::default())
        .unwrap_err()
        .to_string();
    for part in [
        "own.urdf:4",
        "link 'on: arm'",
        "package://own_description",
        "--package NAME=DIR",
    ] {
        assert!(missing.contains(part), "{part}: {missing}");
    }
    let package = dir.path().join("elsewhere/own_description");
    fs::create_dir_all(package.join("meshes")).unwrap();
    fs::write(package.join("meshes/tube.stl"), binary_stl(&tube(), 1.0)).unwrap();
    let by_name = Packages {
        named: vec![("own_description".to_owned(), package.clone())],
        ..Packages::default()
    };
    let by_root = Packages {
        roots: vec![dir.path().join("elsewhere")],
        ..Packages::default()
    };
    for packages in [by_name, by_root] {
        assert_covers_the_tube(&fit(dir.path(), uri, &packages).unwrap());
    }
    let within = package.join("urdf");
    fs::create_dir(&within).unwrap();
    assert_covers_the_tube(&fit(&within, uri, &Packages::default()).unwrap());
}

#[test]
fn a_mesh_that_cannot_be_used_is_named_with_the_reason() {
    let dir = TempDir::new().unwrap();
    let write = |file: &str, bytes: &[u8]| fs::write(dir.path().join(file), bytes).unwrap();
    let mut cut = binary_stl(&tube(), 1.0);
    cut.truncate(200);
    write("cut.stl", &cut);
    write("none.obj", b"");
    write("far.stl", &binary_stl(&tube(), 1e20));
    write("big.stl", &binary_stl(&tube(), 1000.0));
    write("what.blend", b"x");
    write("bad.dae", b"<COLLADA/>");
    write("index.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    for (file, reason) in [
        ("cut.stl", "mesh"),
        ("none.obj", "it has no triangles"),
        ("far.stl", "finite numbers"),
        ("big.stl", "scale=\"0.001 0.001 0.001\""),
        ("what.blend", "STL, OBJ and DAE"),
        ("bad.dae", "instance_visual_scene"),
        ("index.obj", "mesh"),
    ] {
        let geometry = format!("<mesh filename='{file}'/>");
        let error = fit(dir.path(), &geometry, &Packages::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains("own.urdf:4: link 'on: arm'"), "{error}");
        assert!(error.contains(reason), "{file}: {error}");
    }
    let scale = "<mesh filename='big.stl' scale='0.001'/>";
    let error = fit(dir.path(), scale, &Packages::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("three numbers"), "{error}");
}

/// The error for `geometry` as the visual of a link without collision: the reader of robots does
/// not look at it.
fn refused_visual(dir: &Path, geometry: &str) -> String {
    let path = urdf(dir, geometry);
    let text = fs::read_to_string(&path).unwrap();
    let part = format!("<collision>\n<geometry>{geometry}</geometry></collision>");
    assert!(text.contains(&part));
    fs::write(
        &path,
        text.replace(&part, &part.replace("collision>", "visual>")),
    )
    .unwrap();
    let files = RobotFiles {
        urdf: path,
        ..RobotFiles::default()
    };
    let fitted = fit_robot(&files, &Packages::default(), RULES);
    fitted.expect_err("accepted").to_string()
}

#[test]
fn a_scale_or_size_without_a_volume_is_refused_with_what_is_allowed() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("tube.stl"), binary_stl(&tube(), 1.0)).unwrap();
    let scaled = |scale: &str| format!("<mesh filename='tube.stl' scale='{scale}'/>");
    let other_than_0 = "numbers other than 0 are needed";
    for (geometry, value, allowed) in [
        (scaled("0 0 0"), "scale=\"0 0 0\"", other_than_0),
        (scaled("1 1 -0.0"), "scale=\"1 1 -0.0\"", other_than_0),
        (scaled("nan 1 1"), "scale=\"nan\"", "a number is needed"),
        (scaled("inf 1 1"), "scale=\"inf\"", "a number is needed"),
        (scaled("1e-6 1e-6 1e-6"), "4.0e-7 m", "at least 0.0001 m"),
        ("<sphere radius='0'/>".into(), "radius=\"0\"", "above 0 m"),
        (
            "<sphere radius='-0.1'/>".into(),
            "radius=\"-0.1\"",
            "above 0 m",
        ),
        (
            "<sphere radius='NaN'/>".into(),
            "radius=\"NaN\"",
            "a number",
        ),
        (
            "<box size='0.1 0 0.1'/>".into(),
            "size=\"0.1 0 0.1\"",
            "above 0 m",
        ),
        ("<box/>".into(), "size=\"\"", "above 0 m"),
        (
            "<cylinder radius='0.1' length='-1'/>".into(),
            "length=\"-1\"",
            "above 0 m",
        ),
    ] {
        let error = refused_visual(dir.path(), &geometry);
        assert!(error.contains("own.urdf:4: link 'on: arm'"), "{error}");
        assert!(error.contains(value) && error.contains(allowed), "{error}");
    }
    // A mirror is legal: one mesh is that of both arms of a robot.
    let mirrored = fit(dir.path(), &scaled("1 -1 1"), &Packages::default());
    assert_covers_the_tube(&mirrored.unwrap());
}

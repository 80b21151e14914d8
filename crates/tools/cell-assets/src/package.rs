//! The one package meshes come from, and which of its files dresses which link.

/// Name in the Python package index.
pub const PACKAGE: &str = "example-robot-data";
/// The version this table was written for.
pub const VERSION: &str = "6.0.0";
/// What pip is asked for.
pub const REQUIREMENT: &str = "example-robot-data==6.0.0";
/// Name of the file pip stores.
pub const WHEEL: &str = "example_robot_data-6.0.0-0-py3-none-any.whl";
/// sha256 of that file.
pub const SHA256: &str = "424092a8093411ac2cd4ccc0572382bfc6b5eb4833aa984ef5e671dd67cd0a6e";

const PANDA: &str = "cmeel.prefix/share/example-robot-data/robots/panda_description";
const UR: &str = "cmeel.prefix/share/example-robot-data/robots/ur_description";

/// One link and the mesh that dresses it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkMesh {
    /// Folder name of the robot in this repository.
    pub robot: &'static str,
    /// Link in the robot's URDF. Its frame is the one the mesh was drawn in,
    /// but for `half_turn`.
    pub link: &'static str,
    /// Name of the mesh file, without folder and extension.
    file: &'static str,
    /// The mesh is turned by half a turn about the link's Z axis: the right
    /// finger is the left one turned round.
    pub half_turn: bool,
}

impl LinkMesh {
    /// Name of the mesh in the package.
    pub fn member(&self) -> String {
        let folder = match self.robot {
            "panda" => format!("{PANDA}/meshes/visual"),
            _ => format!("{UR}/meshes/ur10/visual"),
        };
        format!("{folder}/{}.dae", self.file)
    }
}

const fn mesh(robot: &'static str, link: &'static str, file: &'static str) -> LinkMesh {
    let half_turn = false;
    LinkMesh {
        robot,
        link,
        file,
        half_turn,
    }
}

/// Every link with a mesh. The package's own URDF files give the visuals of all
/// these links no origin, except the half turn of the right finger.
pub const LINKS: [LinkMesh; 18] = [
    mesh("panda", "panda_link0", "link0"),
    mesh("panda", "panda_link1", "link1"),
    mesh("panda", "panda_link2", "link2"),
    mesh("panda", "panda_link3", "link3"),
    mesh("panda", "panda_link4", "link4"),
    mesh("panda", "panda_link5", "link5"),
    mesh("panda", "panda_link6", "link6"),
    mesh("panda", "panda_link7", "link7"),
    mesh("panda", "panda_hand", "hand"),
    mesh("panda", "panda_leftfinger", "finger"),
    LinkMesh {
        half_turn: true,
        ..mesh("panda", "panda_rightfinger", "finger")
    },
    mesh("ur10", "base_link", "base"),
    mesh("ur10", "shoulder_link", "shoulder"),
    mesh("ur10", "upper_arm_link", "upperarm"),
    mesh("ur10", "forearm_link", "forearm"),
    mesh("ur10", "wrist_1_link", "wrist1"),
    mesh("ur10", "wrist_2_link", "wrist2"),
    mesh("ur10", "wrist_3_link", "wrist3"),
];

/// A notice of the package that goes with the meshes.
#[derive(Debug, Clone, Copy)]
pub struct Notice {
    /// Name of our copy.
    pub name: &'static str,
    /// Name in the package.
    pub member: &'static str,
    /// The robot, or the package, that it covers.
    pub covers: &'static str,
}

/// Licence files and statements of origin the package has for these robots.
/// For the UR10 it states a licence (BSD) but carries no text of it.
pub const NOTICES: [Notice; 4] = [
    Notice {
        name: "panda-LICENSE.txt",
        member: "cmeel.prefix/share/example-robot-data/robots/panda_description/LICENSE",
        covers: "panda",
    },
    Notice {
        name: "panda-README.md",
        member: "cmeel.prefix/share/example-robot-data/robots/panda_description/README.md",
        covers: "panda",
    },
    Notice {
        name: "ur10-README.md",
        member: "cmeel.prefix/share/example-robot-data/robots/ur_description/README.md",
        covers: "ur10",
    },
    Notice {
        name: "package-LICENSE.txt",
        member: "example_robot_data-6.0.0.dist-info/licenses/LICENSE",
        covers: "the package",
    },
];

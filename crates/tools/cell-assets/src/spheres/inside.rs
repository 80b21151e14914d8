//! The inside of a surface, which may be open and may have more surfaces within.

use std::collections::BTreeSet;

use nalgebra::Point3;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::voxelization::{FillMode, VoxelSet};

use crate::spheres::surface::Surface;

/// Cells along the longest edge of a link.
const CELLS: u32 = 32;
/// So many of the 26 directions to the neighbours of a cell have to meet the surface:
/// meshes of links are often tubes with open ends, of which the inside is enclosed by most.
const ENCLOSING: usize = 18;

type Cell = [i32; 3];

/// The cells of a surface.
pub(crate) struct Inside {
    origin: Vector,
    scale: f64,
    grid: Grid,
}

impl Inside {
    pub(crate) fn new(surface: &Surface) -> Self {
        let points = surface.points.iter();
        let points: Vec<Vector> = points.map(|p| Vector::new(p.x, p.y, p.z)).collect();
        // Not parry's flood fill, which finds no inside of a tube with open ends (ADR 0022).
        let kind = FillMode::SurfaceOnly;
        let voxels = VoxelSet::voxelize(&points, &surface.triangles, CELLS, kind, false);
        let walls: BTreeSet<Cell> = voxels
            .voxels()
            .iter()
            .map(|voxel| {
                let at = voxel.coords;
                [at.x, at.y, at.z].map(|x| i32::try_from(x).unwrap_or(0))
            })
            .collect();
        Self {
            origin: voxels.origin,
            scale: voxels.scale,
            grid: Grid::new(&walls),
        }
    }

    /// Centres of the cells inside.
    pub(crate) fn centres(&self) -> Vec<Point3<f64>> {
        let found = self.grid.cells().filter(|cell| self.grid.is_inside(*cell));
        found
            .map(|cell| {
                let point = self.origin + Vector::from(cell.map(f64::from)) * self.scale;
                Point3::new(point.x, point.y, point.z)
            })
            .collect()
    }

    /// Whether `point` of the surface can be seen from outside.
    pub(crate) fn is_outer(&self, point: &Point3<f64>) -> bool {
        let at = (Vector::new(point.x, point.y, point.z) - self.origin) / self.scale;
        #[expect(clippy::cast_possible_truncation, reason = "within the grid")]
        let cell = [at.x, at.y, at.z].map(|x| x.round() as i32);
        !self.grid.is_inside(cell)
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Wall,
    Enclosed,
    Outside,
}

struct Grid {
    lowest: Cell,
    counts: [i32; 3],
    kinds: Vec<Kind>,
}

impl Grid {
    fn new(walls: &BTreeSet<Cell>) -> Self {
        let bound = |axis: usize, best: fn(i32, i32) -> i32| {
            walls
                .iter()
                .map(|cell| cell[axis])
                .reduce(best)
                .unwrap_or(0)
        };
        let lowest = [0, 1, 2].map(|axis| bound(axis, i32::min));
        let highest = [0, 1, 2].map(|axis| bound(axis, i32::max));
        let counts = [0, 1, 2].map(|axis| highest[axis] - lowest[axis] + 1);
        let mut grid = Self {
            lowest,
            counts,
            kinds: Vec::new(),
        };
        let is_wall = |cell: Cell| walls.contains(&cell);
        let kind = |cell: Cell| {
            if is_wall(cell) {
                Kind::Wall
            } else {
                Kind::Outside
            }
        };
        grid.kinds = grid.cells().map(kind).collect();
        let enclosed = grid.cells().map(|cell| grid.encloses(cell));
        let kinds = grid.kinds.iter().zip(enclosed);
        grid.kinds = kinds
            .map(|(kind, enclosed)| if enclosed { Kind::Enclosed } else { *kind })
            .collect();
        grid
    }

    fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        let ([x, y, z], [a, b, c]) = (self.lowest, self.counts);
        (x..x + a)
            .flat_map(move |i| (y..y + b).flat_map(move |j| (z..z + c).map(move |k| [i, j, k])))
    }

    fn within(&self, cell: Cell) -> Option<Kind> {
        let mut index = 0;
        for ((at, lowest), count) in cell.iter().zip(self.lowest).zip(self.counts) {
            let at = at - lowest;
            if !(0..count).contains(&at) {
                return None;
            }
            index = index * count + at;
        }
        self.kinds.get(usize::try_from(index).ok()?).copied()
    }

    fn kind(&self, cell: Cell) -> Kind {
        self.within(cell).unwrap_or(Kind::Outside)
    }

    /// A cell that has walls around it, or is a wall with nothing of the outside beside it.
    fn is_inside(&self, cell: Cell) -> bool {
        match self.kind(cell) {
            Kind::Enclosed => true,
            Kind::Outside => false,
            Kind::Wall => {
                directions().all(|step| self.kind(step_from(cell, step, 1)) != Kind::Outside)
            }
        }
    }

    fn encloses(&self, cell: Cell) -> bool {
        let meets = |step: &Cell| {
            let mut ray = (1..).map_while(|n| self.within(step_from(cell, *step, n)));
            ray.any(|kind| kind == Kind::Wall)
        };
        self.kind(cell) != Kind::Wall && directions().filter(meets).count() >= ENCLOSING
    }
}

/// Steps to the neighbours of a cell.
fn directions() -> impl Iterator<Item = Cell> {
    let steps = (0..27).map(|n| [n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1]);
    steps.filter(|step| *step != [0, 0, 0])
}

fn step_from(cell: Cell, step: Cell, count: i32) -> Cell {
    [0, 1, 2].map(|axis| cell[axis] + count * step[axis])
}

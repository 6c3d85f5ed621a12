//! Distance from every cell to the nearest obstacle, exact, in integers.

use super::{Cell, GridFrame, ObstacleGrid};

/// For each cell the squared distance, in cells, from its centre to the centre of the nearest obstacle cell.
///
/// Exact Euclidean distances by the two passes of Meijster, Roerdink and Hesselink (2000): one along the columns,
/// one lower envelope of parabolas along each row. Linear in the number of cells, integers throughout.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    frame: GridFrame,
    squared: Vec<u32>,
}

/// Stands for "no obstacle in this column"; its square with the largest row offset still fits in a `u32`.
const FAR: i32 = 46_000;

impl DistanceField {
    /// The squared distance stored where the grid holds no obstacle at all.
    pub const NO_OBSTACLE: u32 = (FAR * FAR) as u32;

    /// The field of an obstacle grid. Ground outside the grid is not an obstacle here: the field knows only cells.
    #[must_use]
    pub fn new(obstacles: &ObstacleGrid) -> Self {
        let frame = *obstacles.frame();
        let along_columns = distance_along_columns(obstacles);
        let mut squared = vec![0; frame.len()];
        let width = frame.width as usize;
        let mut envelope = Envelope::with_capacity(width);
        for (row, out) in along_columns
            .chunks_exact(width)
            .zip(squared.chunks_exact_mut(width))
        {
            envelope.lower(row, out);
        }
        Self { frame, squared }
    }

    /// Size and placement.
    #[must_use]
    pub const fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// All squared distances in cells, row-major, lowest row first.
    #[must_use]
    pub fn squared_cells(&self) -> &[u32] {
        &self.squared
    }

    /// Distance in metres from the centre of a cell to the centre of the nearest obstacle cell; infinite where the
    /// grid holds no obstacle. The cell must lie inside the grid.
    #[must_use]
    pub fn distance_m(&self, cell: Cell) -> f64 {
        match self.squared[self.frame.index(cell)] {
            Self::NO_OBSTACLE.. => f64::INFINITY,
            squared => f64::from(squared).sqrt() * self.frame.resolution_m,
        }
    }
}

/// For each cell the distance, in rows, to the nearest obstacle of its own column, or [`FAR`].
fn distance_along_columns(obstacles: &ObstacleGrid) -> Vec<i32> {
    let width = obstacles.frame().width as usize;
    let mut distance: Vec<i32> = obstacles
        .cells()
        .iter()
        .map(|&blocked| if blocked { 0 } else { FAR })
        .collect();
    for index in width..distance.len() {
        distance[index] = distance[index].min(distance[index - width] + 1);
    }
    for index in (0..distance.len().saturating_sub(width)).rev() {
        distance[index] = distance[index].min(distance[index + width] + 1);
    }
    distance
}

/// The lower envelope of the parabolas `(x - site)^2 + height(site)^2` of one row.
struct Envelope {
    sites: Vec<i32>,
    /// The first column where the site of the same position is the lowest.
    starts: Vec<i32>,
}

impl Envelope {
    fn with_capacity(width: usize) -> Self {
        Self {
            sites: Vec::with_capacity(width),
            starts: Vec::with_capacity(width),
        }
    }

    fn lower(&mut self, heights: &[i32], out: &mut [u32]) {
        self.sites.clear();
        self.starts.clear();
        let width = heights.len() as i32;
        let value = |x: i32, site: i32| {
            let height = i64::from(heights[site as usize]);
            i64::from(x - site).pow(2) + height * height
        };
        // The last column where an earlier site is not above a later one.
        let last_of_earlier = |earlier: i32, later: i32| {
            let (a, b) = (
                i64::from(heights[earlier as usize]),
                i64::from(heights[later as usize]),
            );
            let (u, v) = (i64::from(earlier), i64::from(later));
            (v * v - u * u + b * b - a * a).div_euclid(2 * (v - u))
        };
        for site in 0..width {
            if heights[site as usize] >= FAR {
                continue;
            }
            while let (Some(&top), Some(&start)) = (self.sites.last(), self.starts.last()) {
                if value(start, top) <= value(start, site) {
                    break;
                }
                self.sites.pop();
                self.starts.pop();
            }
            let start = match self.sites.last() {
                None => 0,
                Some(&top) => last_of_earlier(top, site) + 1,
            };
            if start < i64::from(width) {
                self.sites.push(site);
                self.starts.push(start as i32);
            }
        }
        let mut remaining = width;
        if self.sites.is_empty() {
            out.fill(DistanceField::NO_OBSTACLE);
        }
        for (&site, &start) in self.sites.iter().zip(&self.starts).rev() {
            for x in start..remaining {
                out[x as usize] = value(x, site) as u32;
            }
            remaining = start;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use rand::{RngExt, SeedableRng};

    fn brute_force(obstacles: &ObstacleGrid) -> Vec<u32> {
        let frame = obstacles.frame();
        let sites: Vec<Cell> = (0..frame.len())
            .filter(|&i| obstacles.cells()[i])
            .map(|i| frame.cell_at(i))
            .collect();
        (0..frame.len())
            .map(|index| {
                let cell = frame.cell_at(index);
                sites
                    .iter()
                    .map(|site| {
                        let (dx, dy) = (site.column - cell.column, site.row - cell.row);
                        (dx * dx + dy * dy) as u32
                    })
                    .min()
                    .unwrap_or(DistanceField::NO_OBSTACLE)
            })
            .collect()
    }

    #[test]
    fn equals_brute_force_on_random_grids() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
        for case in 0..200 {
            let (width, height) = (rng.random_range(1..40), rng.random_range(1..40));
            let frame = GridFrame {
                width,
                height,
                resolution_m: 0.1,
                origin: Pose::default(),
            };
            let density = [0.0, 0.002, 0.05, 0.5, 1.0][case % 5];
            let blocked = (0..frame.len()).map(|_| rng.random_bool(density)).collect();
            let obstacles = ObstacleGrid::new(frame, blocked);
            let field = DistanceField::new(&obstacles);
            assert_eq!(
                field.squared_cells(),
                brute_force(&obstacles),
                "case {case}"
            );
        }
    }
}

//! Writing of ROS `map_server` maps.

use core::fmt::Write as _;

use super::{OCCUPIED_THRESHOLD, OccupancyGrid, UNKNOWN};

/// First lines of the files.
const YAML_HEAD: &str = "# Map written by inbye.";
const PGM_HEAD: &str = "P5\n# inbye";

/// Grey values of occupied, free and unknown cells, as ROS map savers write them.
const OCCUPIED_GREY: u8 = 0;
const FREE_GREY: u8 = 254;
const UNKNOWN_GREY: u8 = 205;

impl OccupancyGrid {
    /// The map as a `map_server` file in mode `trinary`: the text of the YAML file, which names the image, and the bytes of the
    /// PGM image. Cells of at least [`OCCUPIED_THRESHOLD`] percent are occupied, and other known cells are free.
    #[must_use]
    pub fn to_map_server(&self, image: &str) -> (String, Vec<u8>) {
        let frame = self.frame();
        let mut yaml = String::new();
        let quoted = image.replace('\\', "\\\\").replace('"', "\\\"");
        let origin = frame.origin;
        // Writing to a string does not fail.
        let _ = write!(
            yaml,
            "{YAML_HEAD}\nimage: \"{quoted}\"\nmode: trinary\nresolution: {:?}\norigin: [{:?}, {:?}, {:?}]\nnegate: 0\n\
             occupied_thresh: 0.65\nfree_thresh: 0.19\n",
            frame.resolution_m, origin.x, origin.y, origin.yaw
        );
        let mut pgm = format!("{PGM_HEAD}\n{} {}\n255\n", frame.width, frame.height).into_bytes();
        let grey = |value: &i8| match *value {
            UNKNOWN => UNKNOWN_GREY,
            value if value >= OCCUPIED_THRESHOLD => OCCUPIED_GREY,
            _ => FREE_GREY,
        };
        for row in self.cells().chunks_exact(frame.width as usize).rev() {
            pgm.extend(row.iter().map(grey));
        }
        (yaml, pgm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::GridFrame;

    #[test]
    fn written_map_reads_as_the_same_map() {
        let origin = Pose::new(-1.25, 3.0, 0.5);
        let frame = GridFrame::new(3, 2, 0.05, origin).expect("a frame");
        let map = OccupancyGrid::new(frame, vec![0, 100, UNKNOWN, 100, 0, 0]);
        let (yaml, pgm) = map.to_map_server("a \"b\".pgm");
        assert_eq!(OccupancyGrid::from_map_server(&yaml, &pgm), Ok(map));
    }
}

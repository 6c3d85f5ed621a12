//! `nav_msgs/OccupancyGrid`: the map.

use crate::map::OccupancyGrid;
use crate::recording::cdr::{Decoder, Encoder};
use crate::recording::parts::{self, MAP};

/// A map as the message has it: its resolution is rounded to float32.
pub fn map(grid: &OccupancyGrid) -> Vec<u8> {
    let frame = grid.frame();
    let mut message = Encoder::new();
    parts::header(&mut message, 0.0, MAP);
    parts::time(&mut message, 0.0);
    message.f32(frame.resolution_m);
    message.u32(frame.width as u32);
    message.u32(frame.height as u32);
    parts::pose(&mut message, &frame.origin);
    message.all_i8(grid.cells());
    message.finish()
}

/// The cells of such a message; none of one that is damaged.
pub fn map_cells(message: &[u8]) -> Option<Vec<i8>> {
    let mut read = Decoder::new(message)?;
    // Two times, with the frame's name between them.
    let _ = (read.i32()?, read.u32()?, read.text()?);
    let _ = (read.i32()?, read.u32()?, read.f32()?);
    let _ = (read.u32()?, read.u32()?);
    for _ in 0..7 {
        read.f64()?;
    }
    read.all_i8()
}

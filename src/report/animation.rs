//! A drive as an animated GIF: the surroundings of the robot, its trajectories and its lidar, with a small map of the whole.
//!
//! The frames are drawn directly, because a picture as SVG for each of hundreds of frames would take minutes.

use std::collections::HashMap;

use color_quant::NeuQuant;
use gif::{AnyExtension, Encoder, EncodingError, Extension, Repeat};
use resvg::tiny_skia::{
    Color, FillRule, IntRect, LineCap, LineJoin, Paint, PathBuilder, Pixmap, PixmapPaint, Rect,
    Stroke, Transform,
};
use thiserror::Error;

use super::mission_page::MissionView;
use super::number::{fixed, significant};
use super::player::PlaybackRecorder;
use super::player::playback_recorder::{Frame, MIN_SCORE, NO_RETURN, Window};
use super::png::{PngError, draw_svg};
use crate::geometry::{Point, Twist, Vector};
use crate::map::{GridFrame, OCCUPIED_THRESHOLD, OccupancyGrid, UNKNOWN};
use crate::robot::Polygon;

/// Size of the picture, pixels.
const WIDTH_PX: u32 = 640;
const HEIGHT_PX: u32 = 400;
/// Width of the shown surroundings, metres.
const ACROSS_M: f64 = 14.0;
/// Longer side of the small map, pixels, and its distance from the border.
const MAP_PX: u32 = 176;
const MAP_MARGIN_PX: u32 = 8;
/// Time of a frame, hundredths of a second, and of the last one.
const DELAY: u16 = 8;
const LAST_DELAY: u16 = 200;
/// Most frames: a longer drive is shown faster.
const MAX_FRAMES: usize = 160;
/// Frames from which the palette is chosen, and the share of their pixels: one in this many.
const PALETTE_FRAMES: usize = 12;
const NEU_QUANT_SHARE: i32 = 10;
/// The comment that names the program which wrote the file.
const WRITER: &[u8] = b"inbye";
/// Colours of a GIF.
const COLOURS: usize = 256;
/// Points of a drawn trajectory.
const ARC_PARTS: u32 = 12;

/// The colours of the light theme of pages.
const FREE: [u8; 3] = [0xff, 0xff, 0xff];
const ROCK: [u8; 3] = [0x94, 0x94, 0x94];
const UNKNOWN_GREY: [u8; 3] = [0xca, 0xca, 0xca];
const OUTSIDE: [u8; 3] = [0xc9, 0xce, 0xd6];
const INK: [u8; 3] = [0x1a, 0x1e, 0x24];
const ROBOT: [u8; 3] = [0x00, 0x68, 0xa8];
const COMMAND: [u8; 3] = [0xb8, 0x6e, 0x00];
const PATH: [u8; 3] = [0x00, 0x80, 0x5e];
const MOVING: [u8; 3] = [0xc2, 0x4a, 0x00];
const RETURN: [u8; 3] = [0xb3, 0x26, 0x1e];
/// From the least to the greatest score.
const SCORES: [[u8; 3]; 4] =
    [[0x8f, 0xd0, 0xf2], [0x3d, 0x9f, 0xd8], [0x00, 0x68, 0xa8], [0x04, 0x31, 0x5c]];

/// A drive that cannot be shown as an animation.
#[derive(Debug, Error)]
pub enum AnimationError {
    /// The drive has no tick.
    #[error("the drive has no tick: nothing can be shown")]
    Empty,
    /// A frame cannot be drawn.
    #[error(transparent)]
    Picture(#[from] PngError),
    /// The frames cannot be encoded.
    #[error("the animation cannot be encoded: {0}")]
    Encoding(#[from] EncodingError),
}

/// Returns a drive as a GIF file, 640 by 400 pixels and at most 160 frames, which repeats for ever.
///
/// # Errors
/// Fails for a drive without ticks.
pub fn gif_animation(
    mission: &MissionView<'_>,
    playback: &PlaybackRecorder,
) -> Result<Vec<u8>, AnimationError> {
    let all = &playback.frames;
    let (Some(first), Some(last)) = (all.first(), all.last()) else {
        return Err(AnimationError::Empty);
    };
    // The last frame shows the end of the drive.
    let end = all.len() - 1;
    let stride = end.div_ceil(MAX_FRAMES - 1).max(1);
    let shown: Vec<usize> = (0..end).step_by(stride).chain([end]).collect();
    let shown_s = shown.len() as f64 * f64::from(DELAY) / 100.0;
    let speed_up = (last.row.time_s - first.row.time_s) / shown_s;
    let scene = Scene::new(mission, playback, speed_up)?;
    let every = shown.len().div_ceil(PALETTE_FRAMES);
    let mut samples = Vec::new();
    for &index in shown.iter().step_by(every) {
        samples.extend_from_slice(scene.draw(index)?.data());
    }
    let palette = NeuQuant::new(NEU_QUANT_SHARE, COLOURS, &samples);
    let mut nearest = HashMap::new();
    let mut bytes = Vec::new();
    let mut encoder =
        Encoder::new(&mut bytes, WIDTH_PX as u16, HEIGHT_PX as u16, &palette.color_map_rgb())?;
    encoder.set_repeat(Repeat::Infinite)?;
    // By the comment the next run recognises its own file.
    encoder.write_raw_extension(AnyExtension(Extension::Comment as u8), &[WRITER])?;
    for &index in &shown {
        let picture = scene.draw(index)?;
        let (pixels, _) = picture.data().as_chunks::<4>();
        let indices: Vec<u8> = pixels
            .iter()
            .map(|pixel| *nearest.entry(*pixel).or_insert_with(|| palette.index_of(pixel) as u8))
            .collect();
        let mut frame =
            gif::Frame::from_indexed_pixels(WIDTH_PX as u16, HEIGHT_PX as u16, indices, None);
        frame.delay = if index == all.len() - 1 { LAST_DELAY } else { DELAY };
        encoder.write_frame(&frame)?;
    }
    drop(encoder);
    Ok(bytes)
}

/// What all frames share.
struct Scene<'a> {
    mission: &'a MissionView<'a>,
    frames: &'a [Frame],
    /// Simulated over shown time.
    speed_up: f64,
    /// The whole map with the first path.
    map: Pixmap,
    map_view: View,
}

impl<'a> Scene<'a> {
    fn new(
        mission: &'a MissionView<'a>,
        playback: &'a PlaybackRecorder,
        speed_up: f64,
    ) -> Result<Self, AnimationError> {
        let grid = &mission.mission.map;
        let (map_view, [width_px, height_px]) = View::of_map(grid.frame());
        let mut map = new_pixmap(width_px, height_px)?;
        map_view.fill_cells(grid, &mut map);
        if let Some(path) = mission.result.trace.paths.first() {
            map_view.line(&mut map, path, PATH, 2.0, 1.0);
        }
        Ok(Self { mission, frames: &playback.frames, speed_up, map, map_view })
    }

    /// Draws a frame of the playback.
    fn draw(&self, index: usize) -> Result<Pixmap, AnimationError> {
        let frame = &self.frames[index];
        let row = &frame.row;
        let mut picture = new_pixmap(WIDTH_PX, HEIGHT_PX)?;
        let view = View::around(&row.pose.position());
        view.fill_cells(&self.mission.mission.map, &mut picture);
        if let Some(path) = self.mission.result.trace.paths.get(row.path) {
            view.line(&mut picture, path, PATH, 7.0, 0.4);
        }
        view.disc(&mut picture, &self.mission.mission.goal.position, 0.15, INK, 1.0);
        view.disc(&mut picture, &row.local_target, 0.09, PATH, 1.0);
        let track: Vec<Point> =
            self.frames[..=index].iter().map(|frame| frame.row.pose.position()).collect();
        view.line(&mut picture, &track, ROBOT, 2.0, 0.6);
        view.lidar(&mut picture, frame);
        for disc in &frame.moving {
            view.disc(&mut picture, &disc.center(), disc.radius, MOVING, 0.75);
        }
        if let Some(window) = &frame.window {
            view.trajectories(&mut picture, window);
        }
        let footprint = &self.mission.config.robot.footprint;
        if let Some(body) = footprint.body() {
            view.area(&mut picture, &body.mapped(|corner| row.pose.transform(corner)), ROBOT, 0.75);
        } else {
            for (center, radius_m) in footprint.at(&row.pose) {
                view.disc(&mut picture, &center, radius_m, ROBOT, 0.75);
            }
        }
        let front = row.pose.transform(&Point::new(footprint.front_m(), 0.0));
        view.line(&mut picture, &[row.pose.position(), front], INK, 2.0, 1.0);
        self.draw_map(&mut picture, &row.pose.position());
        draw_svg(&self.label(frame), &mut picture)?;
        Ok(picture)
    }

    /// Draws the small map into the lower right corner, with the robot.
    fn draw_map(&self, picture: &mut Pixmap, robot: &Point) {
        let left = (WIDTH_PX - MAP_MARGIN_PX - self.map.width()) as i32;
        let top = (HEIGHT_PX - MAP_MARGIN_PX - self.map.height()) as i32;
        let border =
            IntRect::from_xywh(left - 1, top - 1, self.map.width() + 2, self.map.height() + 2);
        if let Some(border) = border {
            picture.fill_rect(border.to_rect(), &paint(INK, 1.0), Transform::identity(), None);
        }
        let pixels = self.map.as_ref();
        picture.draw_pixmap(
            left,
            top,
            pixels,
            &PixmapPaint::default(),
            Transform::identity(),
            None,
        );
        let [x, y] = self.map_view.at(robot);
        let dot = PathBuilder::from_circle(x + left as f32, y + top as f32, 4.0);
        if let Some(dot) = dot {
            let (paint, identity) = (paint(ROBOT, 1.0), Transform::identity());
            picture.fill_path(&dot, &paint, FillRule::Winding, identity, None);
        }
    }

    /// Time, speed and mode of a frame as SVG.
    fn label(&self, frame: &Frame) -> String {
        let row = &frame.row;
        let mode = row.mode.name().replace('_', " ");
        let text = format!(
            "{:.1} s  ·  {:.2} m/s  ·  gap {} m  ·  {mode}  ·  {} x real time",
            row.time_s,
            row.twist.linear,
            fixed(row.gap_m, 2),
            significant(self.speed_up)
        );
        format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH_PX}" height="{HEIGHT_PX}"><rect width="{WIDTH_PX}" height="26" fill="#fff" fill-opacity="0.85"/><text x="10" y="18" font-size="14" fill="#1a1e24">{text}</text></svg>"##
        )
    }
}

/// A view of the world: the point at a corner or the centre, and pixels for each metre.
struct View {
    /// The point of the map frame at the pixel (0, 0).
    top_left: Point,
    scale: f64,
}

impl View {
    fn around(center: &Point) -> Self {
        let scale = f64::from(WIDTH_PX) / ACROSS_M;
        let half_m = |side_px: u32| f64::from(side_px) / 2.0 / scale;
        let top_left = Point::new(center.x - half_m(WIDTH_PX), center.y + half_m(HEIGHT_PX));
        Self { top_left, scale }
    }

    /// The whole map, and the width and height of its picture, pixels.
    fn of_map(frame: &GridFrame) -> (Self, [u32; 2]) {
        let [low, high] = Point::bounds(frame.corners()).unwrap_or_default();
        let size = high - low;
        let longer_m = size.x.max(size.y);
        // A rounding error of a corner adds no pixel.
        let pixels = |side_m: f64| (side_m / longer_m * f64::from(MAP_PX) - 1e-6).ceil().max(1.0);
        let (scale, height_px) = (f64::from(MAP_PX) / longer_m, pixels(size.y));
        let top_left = Point::new(low.x, low.y + height_px / scale);
        (Self { top_left, scale }, [pixels(size.x) as u32, height_px as u32])
    }

    /// The pixel of a point.
    fn at(&self, point: &Point) -> [f32; 2] {
        let offset = point - self.top_left;
        [(offset.x * self.scale) as f32, (-offset.y * self.scale) as f32]
    }

    /// Fills a picture with the cells of a map.
    fn fill_cells(&self, grid: &OccupancyGrid, picture: &mut Pixmap) {
        let width = picture.width();
        let (pixels, _) = picture.data_mut().as_chunks_mut::<4>();
        for (number, pixel) in (0_u32..).zip(pixels) {
            let (x, y) = (f64::from(number % width) + 0.5, f64::from(number / width) + 0.5);
            let point =
                Point::new(self.top_left.x + x / self.scale, self.top_left.y - y / self.scale);
            let value = grid.frame().cell_of(&point).and_then(|cell| grid.get(cell));
            let [red, green, blue] = match value {
                None => OUTSIDE,
                Some(&UNKNOWN) => UNKNOWN_GREY,
                Some(&value) if value >= OCCUPIED_THRESHOLD => ROCK,
                Some(_) => FREE,
            };
            *pixel = [red, green, blue, u8::MAX];
        }
    }

    /// The lines between points.
    fn path(&self, points: &[Point]) -> PathBuilder {
        let mut path = PathBuilder::new();
        for (index, point) in points.iter().filter(|point| point.is_finite()).enumerate() {
            let [x, y] = self.at(point);
            if index == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
        }
        path
    }

    fn line(
        &self,
        picture: &mut Pixmap,
        points: &[Point],
        colour: [u8; 3],
        width: f32,
        opacity: f32,
    ) {
        let Some(path) = self.path(points).finish() else {
            return;
        };
        let stroke = Stroke {
            width,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        picture.stroke_path(&path, &paint(colour, opacity), &stroke, Transform::identity(), None);
    }

    fn area(&self, picture: &mut Pixmap, outline: &Polygon, colour: [u8; 3], opacity: f32) {
        let mut path = self.path(outline.corners());
        path.close();
        if let Some(area) = path.finish() {
            let paint = paint(colour, opacity);
            picture.fill_path(&area, &paint, FillRule::Winding, Transform::identity(), None);
        }
    }

    fn disc(
        &self,
        picture: &mut Pixmap,
        center: &Point,
        radius_m: f64,
        colour: [u8; 3],
        opacity: f32,
    ) {
        let [x, y] = self.at(center);
        if let Some(disc) = PathBuilder::from_circle(x, y, (radius_m * self.scale) as f32) {
            let paint = paint(colour, opacity);
            picture.fill_path(&disc, &paint, FillRule::Winding, Transform::identity(), None);
        }
    }

    fn lidar(&self, picture: &mut Pixmap, frame: &Frame) {
        let (scan, pose) = (&frame.scan, &frame.row.pose);
        for (beam, &range) in scan.ranges.iter().enumerate() {
            if range >= NO_RETURN {
                continue;
            }
            let range_m = f64::from(range) / f64::from(NO_RETURN - 1) * scan.range_max;
            let (sin, cos) = libm::sincos(scan.angle_min + beam as f64 * scan.angle_increment);
            let [x, y] = self.at(&pose.transform(&(scan.origin + Vector::new(cos, sin) * range_m)));
            if let Some(dot) = Rect::from_xywh(x - 1.5, y - 1.5, 3.0, 3.0) {
                picture.fill_rect(dot, &paint(RETURN, 1.0), Transform::identity(), None);
            }
        }
    }

    /// Draws the sampled trajectories by their score, the best last, and the chosen one.
    fn trajectories(&self, picture: &mut Pixmap, window: &Window) {
        let rows = window.scores.len() / window.columns.max(1);
        let [low, high] = window.ends;
        let between = |low: f64, high: f64, index: usize, count: usize| {
            if count > 1 { low + (high - low) * index as f64 / (count - 1) as f64 } else { low }
        };
        let mut order: Vec<usize> = (0..window.scores.len()).collect();
        order.sort_by_key(|&index| window.scores[index]);
        for index in order {
            let score = window.scores[index];
            let linear = between(low.linear, high.linear, index % window.columns, window.columns);
            let angular = between(low.angular, high.angular, index / window.columns, rows);
            let twist = Twist::new(linear, angular);
            let path = window.paths.get(index);
            let points = path.cloned().unwrap_or_else(|| arc(window, &twist));
            if score < MIN_SCORE {
                self.line(picture, &points, RETURN, 1.0, 0.2);
            } else {
                let step = usize::from(score - MIN_SCORE) * SCORES.len() / 256;
                self.line(picture, &points, SCORES[step], 1.3, 0.9);
            }
        }
        if let Some(winner) = &window.winner {
            let twist = Twist::new(winner.vx, winner.vtheta);
            let path = window.paths.last();
            let points = path.cloned().unwrap_or_else(|| arc(window, &twist));
            self.line(picture, &points, COMMAND, 4.0, 1.0);
        }
    }
}

/// The points of a trajectory at constant velocity.
fn arc(window: &Window, twist: &Twist) -> Vec<Point> {
    window.start.arc(twist, window.horizon_s, ARC_PARTS).collect()
}

fn paint([red, green, blue]: [u8; 3], opacity: f32) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    let part = |byte: u8| f32::from(byte) / 255.0;
    paint.set_color(
        Color::from_rgba(part(red), part(green), part(blue), opacity).unwrap_or(Color::BLACK),
    );
    paint
}

fn new_pixmap(width_px: u32, height_px: u32) -> Result<Pixmap, PngError> {
    Pixmap::new(width_px, height_px).ok_or_else(|| PngError::too_large(width_px, height_px))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    #[test]
    fn small_map_shows_the_whole_of_a_turned_map() {
        for yaw in [0.0, 1.57, 0.5, -2.0] {
            let frame = GridFrame::new(60, 20, 0.1, Pose::new(3.0, -2.0, yaw)).expect("a size");
            let (view, [width_px, height_px]) = View::of_map(&frame);
            assert_eq!(width_px.max(height_px), MAP_PX, "{yaw}");
            for corner in frame.corners() {
                let [x, y] = view.at(&corner);
                let is_shown = (-0.1..=width_px as f32 + 0.1).contains(&x)
                    && (-0.1..=height_px as f32 + 0.1).contains(&y);
                assert!(is_shown, "{yaw}: {x} {y} of {width_px} x {height_px}");
            }
        }
    }
}

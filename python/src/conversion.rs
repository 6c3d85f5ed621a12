//! Poses, points, velocities and errors between Rust and Python.

use core::fmt::Display;

use inbye::geometry::{Point, Pose, Twist};
use inbye::map::{MovingDisc, Scan};
use inbye::navigator::Goal;
use numpy::ndarray::{ArrayView1, Dimension};
use numpy::{Ix1, Ix2, PyArray, PyArray2, PyArrayMethods, PyReadonlyArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::InbyeError;

/// An error of the library as a Python exception.
pub fn raise(error: impl Display) -> PyErr {
    InbyeError::new_err(error.to_string())
}

pub const fn pose_tuple(pose: &Pose) -> (f64, f64, f64) {
    (pose.x, pose.y, pose.yaw)
}

pub const fn twist_tuple(twist: &Twist) -> (f64, f64) {
    (twist.linear, twist.angular)
}

/// An argument of a few numbers. Any other value is a `TypeError` with the name of the argument in a note.
#[derive(Clone, Copy)]
pub struct Numbers<const N: usize>(pub [f64; N]);

impl<'py, const N: usize> FromPyObject<'_, 'py> for Numbers<N> {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let wrong = |_| PyTypeError::new_err(format!("{N} real numbers are expected"));
        value.extract().map(Self).map_err(wrong)
    }
}

/// A whole number of an argument, from zero on.
pub fn whole<T: TryFrom<i128>>(argument: &str, value: i128) -> PyResult<T> {
    let limit = if value < 0 { "at least 0" } else { "below 2^64" };
    T::try_from(value).map_err(|_| raise(format!("{argument} is {value}: it must be {limit}")))
}

pub fn pose(Numbers([x, y, yaw]): Numbers<3>) -> PyResult<Pose> {
    let pose = Pose::new(x, y, yaw);
    if pose.is_finite() { Ok(pose) } else { Err(raise("a pose must have three finite numbers")) }
}

pub fn point(Numbers([x, y]): Numbers<2>) -> PyResult<Point> {
    let point = Point::new(x, y);
    if point.is_finite() { Ok(point) } else { Err(raise("a point must have two finite numbers")) }
}

pub fn twist(Numbers([linear, angular]): Numbers<2>) -> PyResult<Twist> {
    let twist = Twist::new(linear, angular);
    if twist.is_finite() {
        Ok(twist)
    } else {
        Err(raise("a velocity must have two finite numbers"))
    }
}

/// A goal: x, y and optionally yaw.
pub fn goal(values: &[f64]) -> PyResult<Goal> {
    match *values {
        [x, y] => Ok(Goal::at(point(Numbers([x, y]))?)),
        [x, y, yaw] => {
            let pose = pose(Numbers([x, y, yaw]))?;
            Ok(Goal { position: pose.position(), yaw: Some(yaw) })
        }
        _ => Err(raise("a goal is (x, y) or (x, y, yaw)")),
    }
}

/// Moving obstacles from rows of x, y, radius, vx and vy.
pub fn moving_discs(rows: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<MovingDisc>> {
    let Some(rows) = rows else { return Ok(Vec::new()) };
    // An empty list has one dimension.
    if rows.len().is_ok_and(|rows| rows == 0) {
        return Ok(Vec::new());
    }
    let rows = real_array::<Ix2>("obstacles", rows)?;
    let rows = rows.as_array();
    if rows.ncols() != 5 {
        return Err(raise("moving obstacles have five columns: x, y, radius, vx, vy"));
    }
    let disc = |row: ArrayView1<'_, f64>| MovingDisc {
        x: row[0],
        y: row[1],
        radius: row[2],
        vx: row[3],
        vy: row[4],
    };
    Ok(rows.rows().into_iter().map(disc).collect())
}

/// A scan from ranges in metres at equal angles, of a lidar at a place on the robot, by default its origin.
pub fn scan(
    ranges: &Bound<'_, PyAny>,
    lidar_position: Option<Numbers<2>>,
    angle_min: f64,
    angle_increment: f64,
    range_max: f64,
) -> PyResult<Scan> {
    let ranges = real_array::<Ix1>("ranges", ranges)?.as_array().iter().copied().collect();
    let Numbers([x, y]) = lidar_position.unwrap_or(Numbers([0.0; 2]));
    let scan = Scan { origin: Point::new(x, y), angle_min, angle_increment, range_max, ranges };
    scan.validate().map_err(raise)?;
    Ok(scan)
}

/// An argument as an array of real numbers, from an array of any real type or from sequences.
pub fn real_array<'py, D: Dimension>(
    argument: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArray<'py, f64, D>> {
    let wrong = |why: String| raise(format!("{argument}: {why}"));
    check_unmasked(argument, value)?;
    if let Ok(array) = value.cast::<PyArray<f64, D>>()
        && is_aligned(array)
    {
        return array.try_readonly().map_err(|error| wrong(error.to_string()));
    }
    let array = numpy_array(argument, value)?;
    let (kind, name) = dtype(&array)?;
    if !"iuf".contains(&kind) {
        return Err(wrong(format!("real numbers are expected, not values of type {name}")));
    }
    let array = array.call_method1("astype", ("float64",))?;
    let dimensions: usize = array.getattr("ndim")?.extract()?;
    let array = array.cast_into::<PyArray<f64, D>>().map_err(|_| {
        let expected = D::NDIM.unwrap_or_default();
        wrong(format!("an array of dimension {expected} is expected, not {dimensions}"))
    })?;
    array.try_readonly().map_err(|error| wrong(error.to_string()))
}

/// Whether all elements are aligned and a whole number of elements apart. Those of a field of a structured array may not be.
fn is_aligned<D: Dimension>(array: &Bound<'_, PyArray<f64, D>>) -> bool {
    let strides_fit =
        || array.strides().iter().all(|stride| stride % size_of::<f64>() as isize == 0);
    array.data().is_aligned() && strides_fit()
}

/// Rejects an array with masked elements: a conversion would use the values below the mask.
pub fn check_unmasked(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    let is_masked = value.py().import("numpy.ma")?.call_method1("is_masked", (value,))?;
    if is_masked.is_truthy()? {
        return Err(raise(format!("{argument}: elements are masked: fill them first")));
    }
    Ok(())
}

/// An argument as NumPy makes an array of it.
pub fn numpy_array<'py>(argument: &str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let array = value.py().import("numpy")?.call_method1("asarray", (value,));
    array.map_err(|_| raise(format!("{argument}: rows of equal length are expected")))
}

/// The kind of an array's type, as NumPy abbreviates it, and its name.
pub fn dtype(array: &Bound<'_, PyAny>) -> PyResult<(String, String)> {
    let dtype = array.getattr("dtype")?;
    Ok((dtype.getattr("kind")?.extract()?, dtype.str()?.extract()?))
}

/// Points as an array of two columns.
pub fn points<'py>(py: Python<'py>, points: &[Point]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<[f64; 2]> = points.iter().copied().map(Into::into).collect();
    table(py, &rows)
}

/// Rows as an array.
pub fn table<'py, const N: usize>(
    py: Python<'py>,
    rows: &[[f64; N]],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat = rows.iter().flatten().copied().collect();
    let array = numpy::ndarray::Array2::from_shape_vec((rows.len(), N), flat);
    Ok(PyArray2::from_owned_array(py, array.map_err(raise)?))
}

/// A value with a JSON form as a Python object.
pub fn from_json<'py>(
    py: Python<'py>,
    value: &impl serde::Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(raise)?;
    py.import("json")?.call_method1("loads", (text,))
}

//! The problem of one decision.

use inbye::local::DecisionInput;
use pyo3::prelude::*;

use super::conversion::{Numbers, moving_discs, point, pose, raise, twist};
use super::map::Map;
use super::settings::settings;

/// All inputs of one decision.
#[pyclass(frozen, module = "inbye")]
pub struct Problem {
    pub inner: inbye::local::Problem,
}

#[pymethods]
impl Problem {
    #[new]
    #[pyo3(signature = (map, pose, target, *, velocity=Numbers([0.0; 2]), last_command=None, key_node=None, obstacles=None, config=None))]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn new(
        py: Python<'_>,
        map: &Bound<'_, Map>,
        pose: Numbers<3>,
        target: Numbers<2>,
        velocity: Numbers<2>,
        last_command: Option<Numbers<2>>,
        key_node: Option<Numbers<2>>,
        obstacles: Option<&Bound<'_, PyAny>>,
        config: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let config = settings(config)?;
        let map = map.get();
        let (pose, velocity, at) = (self::pose(pose)?, twist(velocity)?, point(target)?);
        // The first problem on a map measures its distances to obstacles.
        let input = py.detach(|| config.decision_input(map, pose, velocity, at)).map_err(raise)?;
        let input = DecisionInput {
            last_command: last_command.map(twist).transpose()?.unwrap_or(velocity),
            obstacles: &moving_discs(obstacles)?,
            key_node: point(key_node.unwrap_or(target))?,
            ..input
        };
        let inner = input.problem(&config.local);
        // Its ranges are checked here rather than at each decision.
        inbye::local::QuantizedProblem::new(&inner).map_err(raise)?;
        Ok(Self { inner })
    }

    /// Number of samples.
    fn __len__(&self) -> usize {
        self.inner.window.len()
    }

    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf
    }

    /// Positions of a sample after each step of the horizon, metres.
    fn path<'py>(
        &self,
        py: Python<'py>,
        index: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, numpy::PyArray2<f64>>> {
        let count = self.__len__();
        let Some(number) = index.extract().ok().filter(|it: &u32| (*it as usize) < count) else {
            let (last, index) = (count - 1, index.repr()?);
            return Err(raise(format!("index is {index}: it must be a whole number, 0 to {last}")));
        };
        super::conversion::points(py, &self.inner.path(number))
    }
}

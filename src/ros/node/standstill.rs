//! Why a robot with a goal does not drive.

use thiserror::Error;

/// What the node waits for. The robot brakes and stands until it comes.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Missing {
    /// No map has come.
    #[error("no map has come")]
    Map,
    /// No odometry has come.
    #[error("no odometry has come")]
    Odometry,
    /// The last odometry is too old.
    #[error("odometry has stopped coming")]
    FreshOdometry,
    /// Nobody says where the odometry's frame lies in the map's.
    #[error(
        "odometry is in the frame `{frame}` and nothing on tf says where that lies in `{map}`: start a localisation, or \
         give --odom-is-map"
    )]
    Transform {
        /// The odometry's.
        frame: String,
        /// The map's.
        map: String,
    },
    /// No scan has come.
    #[error("no scan has come")]
    Scan,
}

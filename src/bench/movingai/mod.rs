//! Grid search against the published optimal lengths of the `MovingAI` benchmark (Sturtevant 2012): every answer judged
//! without the search's help, and timed.

mod algorithms;
mod files;
mod judge;
mod legality;
mod measure;
mod record;
mod tally;

pub use algorithms::{ALGORITHMS, Algorithm, Answer, Search};
pub use files::{Files, Folder, Queries, find, longest};
pub use judge::{TOLERANCE, Verdict, judge};
pub use legality::{IllegalPath, path_length};
pub use measure::Bench;
pub use record::{AlgorithmRow, MapRows};

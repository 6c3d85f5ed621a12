//! Grid search against the published optimal lengths of the `MovingAI` benchmark (Sturtevant 2012): every answer is
//! checked independently of the search, and timed.

mod algorithms;
mod files;
mod legality;
mod measure;
mod path_check;
mod record;
mod statistics;

pub use algorithms::{ALGORITHMS, Algorithm, Answer, Search};
pub use files::{Files, Folder, Queries, find, longest};
pub use legality::{IllegalPath, path_length};
pub use measure::Bench;
pub use path_check::{AnswerCheck, TOLERANCE, check_answer};
pub use record::{AlgorithmRow, MapRows};

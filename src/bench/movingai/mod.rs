//! Grid search against the published optimal lengths of the `MovingAI` benchmark (Sturtevant 2012): every answer is
//! checked independently of the search, and timed.

mod algorithms;
mod files;
mod measure;
mod path_check;

pub use algorithms::{ALGORITHMS, Algorithm, Search};
pub use files::{Files, Folder, Queries, find, longest};
pub use measure::{AlgorithmRow, Bench, MapRows};
pub use path_check::{AnswerCheck, IllegalPath, TOLERANCE, check_answer, path_length};

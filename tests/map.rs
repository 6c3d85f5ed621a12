//! Maps: files and their messages, distance fields, free space, scans and poses.

mod support {
    pub mod hand_png;
    pub mod map_folder;
}

mod cases {
    mod map {
        mod damage;
        mod decoders;
        mod distance_field;
        mod errors;
        mod free_space;
        mod geometry;
        mod reading;
        mod scan;
        mod scenarios;
        mod shipped;
    }
}

//! Map files: what they mean, and what is refused with which message.

mod support {
    pub mod hand_png;
    pub mod map_folder;
}

mod cases {
    mod map {
        mod damage;
        mod decoders;
        mod errors;
        mod reading;
    }
}

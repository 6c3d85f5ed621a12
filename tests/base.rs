//! Bases: protocols, sessions, the supervisor, and the program with an emulated base in another process.

mod support {
    pub mod room;
}

mod cases {
    mod base {
        mod emulated_base;
        mod interface;
        mod protective_layer;
        mod wire;
    }
}

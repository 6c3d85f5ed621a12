//! The interface to a base: frames, sessions, the sender, and the program against an emulated base in another process.

mod cases {
    mod base {
        mod interface;
        mod wire;
        mod wired;
    }
}

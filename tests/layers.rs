//! Rules that a reader of the source relies on, and settings that are documented as they are.

mod cases {
    mod layers {
        mod modules;
        mod settings;
    }
}

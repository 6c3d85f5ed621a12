//! Pages and pictures.

mod cases {
    mod report {
        mod pages;
    }
}

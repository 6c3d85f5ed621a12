//! README and book: the book builds, its links resolve, and each console block prints what it shows.

mod cases {
    mod documents {
        mod book;
        mod c_header;
        mod console;
        mod shell_blocks;
    }
}

//! `c/include/inbye.h` is what cbindgen makes of the sources. `INBYE_WRITE_HEADER=1 cargo test --test documents c_header` writes it.

use std::fs;
use std::path::Path;

use cbindgen::{Builder, Config, DocumentationStyle, EnumConfig, Language, RenameRule, Style};

/// The functions that a controller in a shared library has.
const CONTROLLER: &str = "\
/* A controller in a shared library has the following functions. `inbye-controller-host LIBRARY` calls them, as in
 *   inbye drive --scene mine --controller \"inbye-controller-host ./libmy_controller.so\"
 *
 * The library runs in a process of its own. What it prints to the standard output goes to the standard error output. */

/* Write INBYE_CONTROLLER_ABI once in a library, outside all functions: the host refuses a library of another version. */
#ifdef __cplusplus
#define INBYE_CONTROLLER_ABI \\
    extern \"C\" uint32_t inbye_controller_abi_version() { return INBYE_ABI_VERSION; }
#else
#define INBYE_CONTROLLER_ABI \\
    uint32_t inbye_controller_abi_version(void) { return INBYE_ABI_VERSION; }
#endif

/* INBYE_CONTROLLER_ABI defines it. */
uint32_t inbye_controller_abi_version(void);

/* Makes a controller for a robot. Null is a failure. */
void *inbye_controller_create(const struct InbyeRobot *robot);

/* Writes speed (m/s) and turn rate (rad/s) of this tick. Returns false where there is no valid velocity: the robot brakes. A value
 * that is not finite ends the mission. */
bool inbye_controller_compute_velocity(void *controller, const struct InbyeControllerInput *input, double *linear,
                                       double *angular);

/* Frees a controller. */
void inbye_controller_destroy(void *controller);
";

const START: &str = "\
/* The C interface of inbye: decisions, global paths and a navigator, and controllers in shared libraries.
 *
 * Metres, seconds and radians; x forward, y left, yaw counter-clockwise (REP-103). What a function returns as a pointer belongs to
 * the caller, who frees it with the function of its type. A function that fails returns NULL or false, and inbye_last_error() says
 * why. Objects may move between threads; only one thread at a time may use one, but any number of threads a map or a configuration.
 *
 * cbindgen makes this file of the sources in c/src. */";

fn header() -> String {
    let config = Config {
        language: Language::C,
        cpp_compat: true,
        include_guard: Some("INBYE_H".to_owned()),
        header: Some(START.to_owned()),
        style: Style::Both,
        documentation_style: DocumentationStyle::C,
        usize_is_size_t: true,
        line_length: 120,
        enumeration: EnumConfig {
            rename_variants: RenameRule::QualifiedScreamingSnakeCase,
            ..EnumConfig::default()
        },
        ..Config::default()
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("c/src");
    let mut builder = Builder::new().with_config(config);
    // The modules of the first are followed.
    for file in ["lib.rs", "host/interface.rs"] {
        builder = builder.with_src(root.join(file));
    }
    builder = builder.include_item("InbyeRobot").include_item("InbyeControllerInput");
    let mut text = Vec::new();
    builder.generate().expect("the sources can be parsed").write(&mut text);
    let text = String::from_utf8(text).expect("a header is text");
    let text = text.replace(" # Safety\n ", " Precondition: ");
    // Inside the block that C++ reads as C.
    let end = text.rfind("#ifdef __cplusplus").expect("it ends the block for C++");
    format!("{}{CONTROLLER}\n{}", &text[..end], &text[end..])
}

#[test]
fn committed_header_is_that_of_the_sources() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("c/include/inbye.h");
    let header = header();
    if std::env::var_os("INBYE_WRITE_HEADER").is_some() {
        fs::write(&file, &header).expect("the header can be written");
    }
    let committed = fs::read_to_string(&file).expect("the header is there");
    assert!(
        committed == header,
        "{} is not that of the sources: INBYE_WRITE_HEADER=1 cargo test --test documents c_header writes it",
        file.display()
    );
}

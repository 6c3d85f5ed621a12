//! `c/include/inbye.h` is what cbindgen makes of the sources. `INBYE_WRITE_HEADER=1 cargo test --test documents c_header` writes it.

use std::fs;
use std::path::Path;

use cbindgen::{Builder, Config, DocumentationStyle, EnumConfig, Language, RenameRule, Style};

/// The functions that a controller in a shared library has.
const CONTROLLER: &str = "\
/* A controller in a shared library has the following functions. `inbye-controller-host LIBRARY` calls them, as in
 *   inbye drive --scene mine --controller \"inbye-controller-host ./libmy_controller.so\"
 *
 * The library runs in a process of its own. What it prints to the standard output goes to the standard error output. In C++,
 * INBYE_CONTROLLER defines all of them for a class. */

/* Makes a function visible outside a library, also where it is compiled with -fvisibility=hidden. */
#if defined(_WIN32)
#define INBYE_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define INBYE_EXPORT __attribute__((visibility(\"default\")))
#else
#define INBYE_EXPORT
#endif

/* Write INBYE_CONTROLLER_ABI once in a library, outside all functions: the host refuses a library of another version. */
#ifdef __cplusplus
#define INBYE_CONTROLLER_ABI \\
    extern \"C\" uint32_t inbye_controller_abi_version() { return INBYE_ABI_VERSION; }
#else
#define INBYE_CONTROLLER_ABI \\
    uint32_t inbye_controller_abi_version(void) { return INBYE_ABI_VERSION; }
#endif

/* INBYE_CONTROLLER_ABI defines it. */
INBYE_EXPORT uint32_t inbye_controller_abi_version(void);

/* Makes a controller for a robot. Null is a failure. No C++ exception may leave this or another function. */
INBYE_EXPORT void *inbye_controller_create(const struct InbyeRobot *robot);

/* Writes speed (m/s) and turn rate (rad/s) of this tick. Returns false where there is no valid velocity: the robot brakes. A value
 * that is not finite ends the mission. */
INBYE_EXPORT bool inbye_controller_compute_velocity(void *controller, const struct InbyeControllerInput *input,
                                                    double *linear, double *angular);

/* Optional: returns why the last call of inbye_controller_create returned null, or that of inbye_controller_compute_velocity false;
 * null for no reason. The text is UTF-8, and stays valid until the next call of a function. */
INBYE_EXPORT const char *inbye_controller_error(void);

/* Frees a controller. */
INBYE_EXPORT void inbye_controller_destroy(void *controller);
";

/// The functions for a class in C++.
const CONTROLLER_CLASS: &str = "\
#ifdef __cplusplus
#include <exception>
#include <string>

namespace inbye_controller {

inline std::string &reason() {
    static std::string text;
    return text;
}

template <typename Result, typename Call>
Result guarded(Result failed, Call call) noexcept {
    reason().clear();
    try {
        return call();
    } catch (const std::exception &error) {
        reason() = error.what();
    } catch (...) {
        reason() = \"an exception that is no std::exception\";
    }
    return failed;
}

}  // namespace inbye_controller

/* Defines all functions of a controller, once in a library and outside all namespaces, for a class with a constructor and a method:
 *   Class(const InbyeRobot &robot);
 *   bool compute_velocity(const InbyeControllerInput &input, double &linear, double &angular);
 * An exception of the constructor is a failure. One of the method counts as false. The text of what() is the reason. */
#define INBYE_CONTROLLER(Class) \\
    INBYE_CONTROLLER_ABI \\
    extern \"C\" void *inbye_controller_create(const InbyeRobot *robot) { \\
        return inbye_controller::guarded<void *>(nullptr, [=]() -> void * { return new Class(*robot); }); \\
    } \\
    extern \"C\" bool inbye_controller_compute_velocity(void *controller, const InbyeControllerInput *input, double *linear, \\
                                                      double *angular) { \\
        return inbye_controller::guarded(false, [=]() -> bool { \\
            return static_cast<Class *>(controller)->compute_velocity(*input, *linear, *angular); \\
        }); \\
    } \\
    extern \"C\" const char *inbye_controller_error() { \\
        return inbye_controller::reason().empty() ? nullptr : inbye_controller::reason().c_str(); \\
    } \\
    extern \"C\" void inbye_controller_destroy(void *controller) { delete static_cast<Class *>(controller); }
#endif
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
    let last = text.rfind("#endif").expect("it ends the guard");
    let (before, closing, guard) = (&text[..end], &text[end..last], &text[last..]);
    format!("{before}{CONTROLLER}\n{closing}{CONTROLLER_CLASS}\n{guard}")
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

//! The shaders, tested without a GPU: they are valid, within the limits of every adapter, and twins of the Rust code.

use core::mem::{offset_of, size_of};

use inbye::local::internals::gpu::{ACCESS, ANSWERS, Access, FIELD, RECORDS};
use inbye::local::internals::gpu::{
    Answer, BATCH_BYTES, BATCH_HEAD_BYTES, BatchEntry, BufferOffsets, MAX_PROBLEMS,
    MAX_TABULATION_ROUNDS, PARTIAL_BYTES, Record, SAMPLES_PER_GROUP, STEPS_PER_GROUP,
};
use inbye::local::internals::gpu::{PARTS, Pipeline, source};
use inbye::local::internals::score::Normalizer;
use inbye::local::internals::{
    Header, ProfileSegment, QuantizedDisc, QuantizedObstacle, TurnProfile, VxSample,
};
use inbye::local::{SampleStatus, Terms};
use inbye::numeric::{HALF_TURN, ONE_Q20, QUARTER_TURN};
use naga::front::wgsl;
use naga::proc::Layouter;
use naga::valid::{Capabilities, GlobalUse, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Expression, Literal, Module, ShaderStage, StorageAccess, TypeInner};

/// Limits that WebGPU guarantees on every adapter.
const MAX_INVOCATIONS: u32 = 256;
const MAX_WORKGROUP_BYTES: u32 = 16_384;
const MAX_STORAGE_BUFFERS: usize = 8;
const MAX_WORKGROUPS: u32 = 65_535;
const MAX_UNIFORM_BYTES: usize = 65_536;

/// Largest number of samples of a problem, and of a batch.
const MAX_SAMPLES: u32 = 1 << 22;

fn module() -> (Module, ModuleInfo) {
    let source = source();
    let module = match wgsl::parse_str(&source) {
        Ok(module) => module,
        Err(error) => panic!("{}", error.emit_to_string(&source)),
    };
    let info = match Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module)
    {
        Ok(info) => info,
        Err(error) => panic!("{}", error.emit_to_string(&source)),
    };
    (module, info)
}

#[test]
fn assembled_module_is_valid_and_has_its_entry_points() {
    let (module, _) = module();
    let names: Vec<&str> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
    let mut used = Pipeline::ALL.map(Pipeline::entry_point).to_vec();
    used.dedup();
    assert_eq!(names, used);
    assert!(module.entry_points.iter().all(|entry| entry.stage == ShaderStage::Compute));
}

#[test]
fn invalid_shader_is_rejected() {
    let broken = source().replacen("header.steps", "header.step", 1);
    assert!(wgsl::parse_str(&broken).is_err());
}

#[test]
fn entry_points_are_within_the_limits_of_every_adapter() {
    let (module, info) = module();
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).expect("a valid module has a layout");
    for (index, entry) in module.entry_points.iter().enumerate() {
        let invocations: u32 = entry.workgroup_size.iter().product();
        assert!(invocations <= MAX_INVOCATIONS, "{}: {invocations}", entry.name);
        let uses = info.get_entry_point(index);
        let used = |space: fn(&AddressSpace) -> bool| {
            let globals = module.global_variables.iter();
            globals.filter(move |(handle, global)| {
                uses[*handle] != GlobalUse::empty() && space(&global.space)
            })
        };
        let shared: u32 = used(|space| matches!(space, AddressSpace::WorkGroup))
            .map(|(_, global)| layouter[global.ty].size)
            .sum();
        assert!(shared <= MAX_WORKGROUP_BYTES, "{}: {shared} bytes", entry.name);
        let buffers = used(|space| matches!(space, AddressSpace::Storage { .. })).count();
        assert!(buffers <= MAX_STORAGE_BUFFERS, "{}: {buffers} buffers", entry.name);
        let (invocations_x, per_group) = match entry.name.as_str() {
            "tabulate_profiles" => (STEPS_PER_GROUP, MAX_TABULATION_ROUNDS),
            "evaluate_samples" | "score_samples" => (SAMPLES_PER_GROUP, SAMPLES_PER_GROUP),
            _ => continue,
        };
        assert_eq!(entry.workgroup_size, [invocations_x, 1, 1], "{}", entry.name);
        // Each problem of a batch rounds up to whole workgroups.
        assert!(
            MAX_SAMPLES.div_ceil(per_group) + MAX_PROBLEMS as u32 <= MAX_WORKGROUPS,
            "{}",
            entry.name
        );
    }
    // All entry points share one bind group layout.
    let storage =
        |global: &naga::GlobalVariable| matches!(global.space, AddressSpace::Storage { .. });
    let all = module.global_variables.iter().filter(|(_, global)| storage(global)).count();
    assert!(all <= MAX_STORAGE_BUFFERS, "{all} storage buffers");
    let uniform = struct_of(&module, "Batch").0;
    assert!(uniform <= MAX_UNIFORM_BYTES, "{uniform} bytes of uniform buffer");
}

#[test]
fn bindings_have_the_access_that_the_shaders_declare() {
    let (module, _) = module();
    let declared = module.global_variables.iter().filter_map(|(_, global)| {
        let access = match global.space {
            AddressSpace::Uniform => Access::Uniform,
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => {
                Access::ReadWrite
            }
            AddressSpace::Storage { .. } => Access::Read,
            _ => return None,
        };
        let binding = global.binding.as_ref()?.binding as usize;
        Some((binding, access, global.name.clone()?))
    });
    let declared: Vec<_> = declared.collect();
    let accesses: Vec<_> =
        declared.iter().map(|(binding, access, _)| (*binding, *access)).collect();
    let expected: Vec<_> = ACCESS.into_iter().enumerate().collect();
    assert_eq!(accesses, expected);
    for (binding, name) in [(FIELD, "field"), (RECORDS, "records"), (ANSWERS, "answers")] {
        assert_eq!(declared[binding].2, name);
    }
}

/// Names of the functions of a source text, in order: lines `fn name(` of any visibility.
fn functions(text: &str, test_module: &str) -> Vec<String> {
    let code = text.split(test_module).next().unwrap_or_default();
    let mut names = Vec::new();
    for line in code.lines() {
        let line = line.trim_start_matches("pub ").trim_start_matches("const ");
        if let Some(rest) = line.strip_prefix("fn ") {
            let end = rest.find(['(', '<']).unwrap_or(rest.len());
            names.push(rest[..end].to_owned());
        }
    }
    names
}

/// A Rust file, its functions without a twin, and the shader's functions without a twin.
struct Twins {
    rust: &'static str,
    shader: &'static str,
    only_rust: &'static [&'static str],
    only_shader: &'static [&'static str],
}

const TWINS: [Twins; 4] = [
    Twins {
        rust: include_str!("../../../src/numeric.rs"),
        shader: "numeric.wgsl",
        only_rust: &[],
        // Rust has u64 and its operators.
        only_shader: &["mul_wide", "add_wide", "sub_wide", "less_wide", "leading_zeros_wide"],
    },
    Twins {
        rust: include_str!("../../../src/local/rollout.rs"),
        shader: "rollout.wgsl",
        // The shader tabulates all steps at once, in tabulate.wgsl.
        only_rust: &["tabulate"],
        only_shader: &[],
    },
    Twins {
        rust: include_str!("../../../src/local/score.rs"),
        shader: "score.wgsl",
        // Rust computes all four together, the shader one at a time.
        only_rust: &["normalizers"],
        only_shader: &["term_normalizer"],
    },
    Twins {
        rust: include_str!("../../../src/local/select.rs"),
        shader: "select.wgsl",
        // The shader accumulates in its workgroups, in evaluate.wgsl and decide.wgsl.
        only_rust: &["count", "accumulate", "merge"],
        // Rust uses a constant and the `<` of i64.
        only_shader: &["no_candidate", "less_signed"],
    },
];

#[test]
fn twins_have_the_same_functions_in_the_same_order() {
    for twins in TWINS {
        let name = twins.shader;
        let part = PARTS.iter().find(|(part, _)| *part == name);
        let (_, text) = part.unwrap_or_else(|| panic!("{name} is not a part of the module"));
        let rust = functions(twins.rust, "#[cfg(test)]");
        let shader = functions(text, "\0");
        for exception in twins.only_rust {
            assert!(rust.contains(&(*exception).to_owned()), "{name}: Rust has no {exception}");
        }
        for exception in twins.only_shader {
            assert!(shader.contains(&(*exception).to_owned()), "{name} has no {exception}");
        }
        let shared = |names: &[String], except: &[&str]| {
            let mut names: Vec<String> = names.to_vec();
            names.retain(|function| !except.contains(&function.as_str()));
            names
        };
        let rust = shared(&rust, twins.only_rust);
        assert!(!rust.is_empty(), "{name}: no functions found");
        assert_eq!(rust, shared(&shader, twins.only_shader), "{name}");
    }
}

/// Size of a struct, and names and offsets of its fields in bytes.
type Layout = (usize, Vec<(&'static str, usize)>);

macro_rules! layout {
    ($struct:ty: $($field:ident),+) => {
        (
            stringify!($struct),
            (size_of::<$struct>(), vec![$((stringify!($field), offset_of!($struct, $field))),+]),
        )
    };
}

#[test]
fn structs_have_the_same_layout_on_both_sides() {
    let (module, _) = module();
    #[rustfmt::skip]
    let all: [(&str, Layout); 10] = [
        layout!(Header: vx_count, profile_count, steps, disc_count, obstacle_count, width, height, cell_bits, start_x,
            start_y, heading, target_x, target_y, key_x, key_y, max_clearance, table_bits, coarse_bits, fine_bits,
            stop_by_arc, outside_is_free, min_max, stamp, segment_count, weights),
        layout!(BufferOffsets: first_groups, first_vx, first_profile, first_list, first_field, first_table, first_record),
        layout!(BatchEntry: header, offsets),
        layout!(VxSample: coarse, fine, velocity_term, stopping_need),
        layout!(TurnProfile: coarse, fine, stopping_need, max_turn, end_turn),
        layout!(ProfileSegment: end, turn, turn_growth, share, share_growth),
        layout!(QuantizedDisc: x, y, radius),
        layout!(QuantizedObstacle: x, y, step_x, step_y, radius),
        layout!(Record: heading, clearance, path, status),
        layout!(Answer: counts, sums_low, sums_high, min, max, normalizers, winner, score_low, score_high,
            stamp, terms),
    ];
    for (name, (size, fields)) in all {
        let (bytes, members) = struct_of(&module, name);
        let members: Vec<(&str, usize)> =
            members.iter().map(|(member, offset)| (member.as_str(), *offset)).collect();
        assert_eq!(members, fields, "{name}");
        assert_eq!(bytes, size, "{name}");
    }
    assert_eq!(struct_of(&module, "Partial").0 as u64, PARTIAL_BYTES);
    let batch = [("count", 0), ("tabulation_rounds", 4), ("problems", BATCH_HEAD_BYTES)];
    let batch = batch.map(|(name, offset)| (name.to_owned(), offset)).to_vec();
    assert_eq!(struct_of(&module, "Batch"), (BATCH_BYTES, batch));
}

/// Structs of both sides that are never copied between host and device.
#[test]
fn terms_and_normalizers_have_the_same_fields() {
    let (module, _) = module();
    let names = |name| {
        let (_, members) = struct_of(&module, name);
        members.into_iter().map(|(member, _)| member).collect::<Vec<_>>()
    };
    // Destructured without `..`, so that a new field is a compile error here.
    let Terms { heading, clearance, velocity, path } = Terms::default();
    assert_eq!([heading, clearance, velocity, path], Terms::default().to_array());
    assert_eq!(names("Terms"), ["heading", "clearance", "velocity", "path"]);
    let Normalizer { offset: _, mantissa: _, bits: _ } = Normalizer::default();
    assert_eq!(names("Normalizer"), ["offset", "mantissa", "bits"]);
}

fn struct_of(module: &Module, name: &str) -> (usize, Vec<(String, usize)>) {
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some((_, naga::Type { inner: TypeInner::Struct { members, span }, .. })) = found else {
        panic!("the shaders have no struct {name}");
    };
    let member = |member: &naga::StructMember| {
        let name = member.name.clone().unwrap_or_default();
        (name, member.offset as usize)
    };
    (*span as usize, members.iter().map(member).collect())
}

#[test]
fn constants_are_equal_on_both_sides() {
    let (module, _) = module();
    let words = |bytes: usize| i64::try_from(bytes / 4).expect("a small struct");
    for (name, rust) in [
        ("ONE_Q20", i64::from(ONE_Q20)),
        ("QUARTER_TURN", i64::from(QUARTER_TURN)),
        ("HALF_TURN", i64::from(HALF_TURN)),
        ("STEPS_PER_GROUP", i64::from(STEPS_PER_GROUP)),
        ("SAMPLES_PER_GROUP", i64::from(SAMPLES_PER_GROUP)),
        ("MAX_PROBLEMS", MAX_PROBLEMS as i64),
        ("OK", SampleStatus::Ok as i64),
        ("COLLISION", SampleStatus::Collision as i64),
        ("CANNOT_STOP", SampleStatus::CannotStop as i64),
        ("OUTSIDE", SampleStatus::Outside as i64),
        ("DISC_WORDS", words(size_of::<QuantizedDisc>())),
        ("OBSTACLE_WORDS", words(size_of::<QuantizedObstacle>())),
    ] {
        assert_eq!(constant(&module, name), rust, "{name}");
    }
}

fn constant(module: &Module, name: &str) -> i64 {
    let named = |constant: &naga::Constant| constant.name.as_deref() == Some(name);
    let found = module.constants.iter().find(|(_, constant)| named(constant));
    let (_, constant) = found.unwrap_or_else(|| panic!("the shaders have no constant {name}"));
    match module.global_expressions[constant.init] {
        Expression::Literal(Literal::I32(value)) => i64::from(value),
        Expression::Literal(Literal::U32(value)) => i64::from(value),
        ref other => panic!("{name} is {other:?}"),
    }
}

//! One decision on each engine, at a few sampling densities; and the distance field it rests on.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use inbye::bench::{Roadway, roadway_field};
use inbye::local::{ClearanceField, Detail, Prepared, open_all};
use inbye::map::{GridFrame, ObstacleGrid};

/// Steps of the horizon.
const STEPS: u32 = 30;

fn decisions(criterion: &mut Criterion) {
    let field = roadway_field();
    let mut engines = open_all(2, |_| ()).expect("two threads");
    for (speeds, turns) in [(20, 40), (70, 72), (128, 128)] {
        let roadway = Roadway {
            vx_samples: speeds,
            vtheta_samples: turns,
            steps: STEPS,
            ..Roadway::default()
        };
        let mut group = criterion.benchmark_group(format!("decision of {speeds} x {turns}"));
        group.throughput(Throughput::Elements(u64::from(speeds * turns * STEPS)));
        group.sample_size(20);
        for engine in &mut engines {
            group.bench_function(BenchmarkId::from_parameter(engine.name()), |bencher| {
                bencher.iter(|| {
                    let prepared =
                        Prepared::new(&roadway.problem(&field, 0)).expect("within the ranges");
                    black_box(
                        engine
                            .evaluate(&prepared, Detail::Answer)
                            .expect("an answer"),
                    )
                });
            });
        }
        group.finish();
    }
}

fn distance_field(criterion: &mut Criterion) {
    let side = 400;
    let origin = inbye::geometry::Pose::default();
    let frame = GridFrame {
        width: side,
        height: side,
        resolution_m: 0.05,
        origin,
    };
    let blocked = (0..frame.len())
        .map(|index| index % 97 == 0 || index % 8111 < 40)
        .collect();
    let obstacles = ObstacleGrid::new(frame, blocked);
    criterion.bench_function("clearance field of 400 x 400", |bencher| {
        bencher.iter(|| black_box(ClearanceField::new(&obstacles).expect("5 cm cells")));
    });
}

criterion_group!(benches, decisions, distance_field);
criterion_main!(benches);

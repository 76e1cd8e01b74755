//! Made-up records for the tests of tables, charts and report. Their figures are plausible, with zeros, gaps and
//! missing cells.

use crate::study::figures::summary;
use crate::study::measure::stats::{mad, median, typical};
use crate::study::measure::{coherence, ray_sets};
use crate::study::record::{
    AbsentRow, AccuracyRow, ClaimRow, CoherenceRow, Disagreements, EMBREE, HitErrors, Machine, MapCells, MapRow,
    MethodRow, OURS, OnSceneRow, OperationCounts, PeerRow, RateRow, Record, RegimeRow, SCHEMA, Samples, ScalingRow,
    SceneSpeedRow, SpeedRow, TracerRow,
};
use crate::study::workload::Counts;
use crate::tracer::Mode;

const TRIANGLES: [&str; 10] = [
    "cramer",
    "moller_trumbore",
    "kensler_shirley",
    "baldwin_weber",
    "pluecker",
    "woop",
    "woop_half_open",
    "woop_dop",
    "moller_trumbore_f64",
    "moller_trumbore_epsilon",
];
const QUADRICS: [&str; 4] = ["naive", "stable", "mixed", "f64"];
const BOXES: [&str; 5] = ["division", "reciprocal", "sign_selected", "fused", "padded"];

const INSTANCES: [(&str, &str); 11] = [
    ("subtract_first", "triangle/moller_trumbore"),
    ("inverse", "triangle/moller_trumbore"),
    ("f64", "triangle/moller_trumbore"),
    ("baked", "triangle/moller_trumbore"),
    ("subtract_first", "triangle/exact"),
    ("subtract_first", "aabb/padded"),
    ("inverse", "aabb/padded"),
    ("f64", "aabb/padded"),
    ("subtract_first", "quadric/stable"),
    ("inverse", "quadric/stable"),
    ("f64", "quadric/stable"),
];

/// The IDs of a full registry.
pub(crate) fn all_ids() -> Vec<String> {
    let triangles = TRIANGLES.iter().map(|name| format!("triangle/{name}"));
    let boxes = BOXES.iter().map(|name| format!("aabb/{name}"));
    let quadrics = QUADRICS.iter().map(|name| format!("quadric/{name}"));
    let instances = INSTANCES.iter().map(|(method, inner)| format!("instance/{method}/{inner}"));
    triangles.chain(boxes).chain(quadrics).chain(instances).collect()
}

/// A record of the given kernels, with plausible figures that differ from kernel to kernel.
pub(crate) fn record_of(ids: &[String]) -> Record {
    let mut record = Record {
        schema: SCHEMA,
        started_unix: 1_800_000_000,
        seconds: 61.5,
        quick: false,
        seed: 1,
        machine: Machine {
            cpu: "Some CPU @ 3 GHz".into(),
            first_level_cache_bytes: Some(48 << 10),
            processors: 2,
            os: "linux".into(),
            target: "x86_64-unknown-linux-gnu".into(),
            target_features: ["avx2", "fma"].map(String::from).to_vec(),
            rustc: "rustc 1.95.0".into(),
            versions: ["raylanes 0.1.0", "glam 0.34.2"].map(String::from).to_vec(),
        },
        kernels: Vec::new(),
        methods: Vec::new(),
        loops: loops(),
        rates: rates(),
        absent: vec![AbsentRow { id: "triangle/elsewhere".into(), reason: "needs fused multiply-add".into() }],
        speed: Vec::new(),
        regimes: regimes(),
        accuracy: Vec::new(),
        claims: Vec::new(),
        maps: maps(),
        map_cells: Vec::new(),
        on_scenes: Vec::new(),
        scene_speed: Vec::new(),
        other_build: None,
        other_speed: Vec::new(),
        other_scene_speed: Vec::new(),
        tracer: tracer_rows(),
        coherence: ["terrain:1e5", "room"].into_iter().flat_map(coherence_rows).collect(),
        scaling: scaling_rows(),
        peers: vec![
            peer_row(OURS, "scalar", 1, &[2.4, 2.5, 2.6]),
            peer_row(OURS, "auto", 1, &[20.0, 21.0, 23.0]),
            peer_row(EMBREE, "robust, medium, 1 ray", 1, &[10.0, 11.0, 11.5]),
        ],
    };
    for (i, id) in ids.iter().enumerate() {
        add_kernel(&mut record, i, id);
    }
    add_scenes(&mut record, ids);
    record.kernels = summary::kernels(&record);
    record
}

/// One scene for each shape that can be traced, and every kernel on it.
fn add_scenes(record: &mut Record, ids: &[String]) {
    for (i, id) in ids.iter().enumerate() {
        let scene = match id.split('/').next() {
            Some("triangle") => "room",
            Some("quadric") => "gallery",
            _ => continue,
        };
        for (number, rays) in ray_sets::NAMES.into_iter().chain(["edges"]).enumerate() {
            record.on_scenes.push(OnSceneRow {
                scene: scene.into(),
                rays: rays.into(),
                kernel: id.clone(),
                ray_count: 262_144,
                solid: 200_000,
                open: 3,
                lost: if rays == "edges" { [0, 5000, 1][i % 3] } else { 0 },
                false_hits: [0, 40][i % 2],
                neighbours: 7,
                displaced: [0, 3][i % 2],
                displacement_p99: 1e-7 * (i + 1) as f64,
                checksum: format!("{i:016x}"),
            });
            if rays == "edges" {
                continue;
            }
            let ns = 40.0 * (1.0 + 0.03 * i as f64) * (1.0 + number as f64);
            record.scene_speed.push(SceneSpeedRow {
                scene: scene.into(),
                rays: rays.into(),
                kernel: id.clone(),
                ns_per_ray: ns,
                ns_per_ray_low: 0.99 * ns,
                ns_per_ray_high: 1.01 * ns,
                mrays_per_second: 1e3 / ns,
                ns_of_rounds: Samples::new(&[vec![0.99 * ns, ns], vec![1.01 * ns, ns]]),
                checksum: format!("{i:016x}"),
            });
        }
    }
}

fn loops() -> Vec<SpeedRow> {
    [("1x1", 0.5), ("8x1", 0.125), ("1x8", 0.25)].map(|(width, ns)| speed_row("loop", width, 1, ns)).into()
}

/// A row with this time per test, in three rounds of one process. All rows have the same disturbances, so none ties
/// with another.
fn speed_row(id: &str, width: &str, threads: usize, ns: f64) -> SpeedRow {
    let mut row = SpeedRow {
        id: id.into(),
        width: width.into(),
        threads,
        ns_per_test: f64::NAN,
        ns_per_test_low: f64::NAN,
        ns_per_test_high: f64::NAN,
        tests_per_second: f64::NAN,
        ns_of_rounds: Samples::default(),
        hit_share: if width == "1x1" { 0.11 } else { 0.57 },
        checksum: String::new(),
    };
    set_rounds(&mut row, &[0.988, 1.0, 1.012].map(|noise| noise * ns));
    row
}

fn rates() -> Vec<RateRow> {
    let rows = [
        ("multiply", "f32", 0.14),
        ("add", "f32", 0.14),
        ("fused", "f32", 0.14),
        ("divide", "f32", 0.8),
        ("multiply and add", "f32", 0.08),
        ("load", "f32", 0.14),
        ("multiply", "f64", 0.28),
        ("add", "f64", 0.28),
        ("divide", "f64", 2.6),
        ("multiply and add", "f64", 0.16),
    ];
    let row = |(operation, precision, ns): (&str, &str, f64)| RateRow {
        operation: operation.into(),
        precision: precision.into(),
        ns_per_operation: ns,
        ns_per_operation_mad: 0.01 * ns,
        operations_per_second: 1e9 / ns,
        samples: 15,
    };
    rows.map(row).into()
}

/// Two scenes with sets of rays where packets gain much, little, and nothing.
fn tracer_rows() -> Vec<TracerRow> {
    let mut rows = Vec::new();
    for (scene, triangles, instances, slowness) in [("spheres", 81_920, 3, 1.0), ("forest:10000", 214_000, 10_001, 2.5)]
    {
        for (rays, gain) in ray_sets::NAMES.into_iter().zip([2.9, 2.5, 0.4, 0.9]) {
            for (mode, mrays) in Mode::ALL.into_iter().zip([2.5, 6.25, 6.25 * gain, 6.2 * f64::max(gain, 1.0)]) {
                for threads in [1, 2] {
                    let mrays_per_second = mrays / slowness * if threads == 1 { 1.0 } else { 1.93 };
                    rows.push(TracerRow {
                        scene: scene.into(),
                        triangles,
                        instances,
                        rays: rays.into(),
                        ray_count: 1_048_576,
                        hits: 700_000,
                        mode: mode.name().into(),
                        kernel: "triangle/woop".into(),
                        threads,
                        mrays_per_second,
                        mrays_per_second_mad: 0.01 * mrays_per_second,
                        ns_of_rounds: Samples::new(&[[0.99, 1.0, 1.01].map(|n| n * 1e3 / mrays_per_second).into()]),
                        build_seconds: 0.21,
                        bytes_per_triangle: 132.5,
                        checksum: "7357c0de".into(),
                    });
                }
            }
        }
    }
    rows
}

/// Packets are fast until the jitter is about 0.1, and slower than single rays after that. Mode scalar counts nothing.
fn coherence_rows(scene: &str) -> Vec<CoherenceRow> {
    let row = |(mode, jitter): (Mode, f64)| {
        let divergence = (jitter / 0.1).min(4.0);
        let (mrays_per_second, nodes, tests, used) = match mode {
            Mode::Scalar => (2.5 - 0.2 * divergence, 0, 0, 0.0),
            Mode::Single => (7.0 - 0.5 * divergence, 12_000_000, 4_000_000, 0.6),
            Mode::Packet => (20.0 / (1.0 + 2.0 * divergence), 2_000_000, 8_000_000, 0.9 / (1.0 + divergence)),
            Mode::Auto => ((20.0 / (1.0 + 2.0 * divergence)).max(6.8 - 0.5 * divergence), 3_000_000, 7_000_000, 0.7),
        };
        CoherenceRow {
            scene: scene.into(),
            jitter,
            mode: mode.name().into(),
            kernel: "triangle/woop".into(),
            ray_count: 1_048_576,
            mrays_per_second,
            mrays_per_second_mad: 0.01 * mrays_per_second,
            nodes,
            leaves: nodes / 3,
            tests,
            lanes: (8.0 * used * tests as f64) as u64,
            checksum: format!("{:x}", jitter.to_bits()),
        }
    };
    coherence::JITTERS.into_iter().flat_map(|jitter| Mode::ALL.map(|mode| (mode, jitter))).map(row).collect()
}

fn scaling_rows() -> Vec<ScalingRow> {
    let sizes = [("terrain:1e4", 10_082), ("terrain:1e5", 100_352), ("terrain:1e6", 1_000_000)];
    let row = |(step, scene, triangles, rays, ns): (usize, &str, usize, &str, f64)| ScalingRow {
        scene: scene.into(),
        triangles,
        rays: rays.into(),
        ray_count: 262_144,
        hits: 200_000,
        kernel: "triangle/woop".into(),
        ns_per_ray: ns * 1.25f64.powi(step as i32),
        ns_per_ray_mad: 0.01 * ns,
        build_seconds: 3e-7 * triangles as f64,
        bytes_per_triangle: 180.0 - step as f64,
        checksum: format!("{triangles:x}"),
    };
    let cells = sizes.into_iter().enumerate().flat_map(|(step, (scene, triangles))| {
        ray_sets::NAMES
            .into_iter()
            .zip([40.0, 50.0, 180.0, 120.0])
            .map(move |(rays, ns)| (step, scene, triangles, rays, ns))
    });
    cells.map(row).collect()
}

/// A row of one tracer configuration, with these million rays per second in its rounds.
pub(crate) fn peer_row(tracer: &str, configuration: &str, threads: usize, mrays: &[f64]) -> PeerRow {
    PeerRow {
        scene: "spheres".into(),
        triangles: 81_920,
        rays: "primary".into(),
        ray_count: 1_048_576,
        hits: 700_000,
        tracer: tracer.into(),
        configuration: configuration.into(),
        watertight: false,
        threads,
        mrays_per_second: median(mrays),
        mrays_per_second_mad: mad(mrays),
        mrays_of_rounds: mrays.to_vec(),
        disagreements: Disagreements { only_first: 1, only_second: 2, ties: 30, other_primitive: 4 },
        build_seconds: 0.21,
        bytes_per_triangle: None,
        checksum: "7357c0de".into(),
    }
}

/// Sets the times of a row to these rounds of one process.
pub(crate) fn set_rounds(row: &mut SpeedRow, ns: &[f64]) {
    row.ns_of_rounds = Samples::new(&[ns.to_vec()]);
    let times = typical(&row.ns_of_rounds).unwrap();
    (row.ns_per_test, row.tests_per_second) = (times.value, 1e9 / times.value);
    (row.ns_per_test_low, row.ns_per_test_high) = (times.low, times.high);
}

/// Degenerate records: one with only the rows of kernels, regimes and maps, one whose figures are zero, and an empty
/// one.
pub(crate) fn degenerate_records() -> [Record; 3] {
    let mut bare = record_of(&all_ids());
    bare.kernels.clear();
    bare.speed.clear();
    bare.rates.clear();
    bare.accuracy.clear();
    bare.claims.clear();
    bare.map_cells.clear();
    clear_tracer(&mut bare);
    let mut zeros = record_of(&all_ids());
    for row in &mut zeros.speed {
        set_rounds(row, &[0.0; 3]);
    }
    for row in &mut zeros.rates {
        (row.ns_per_operation, row.ns_per_operation_mad, row.operations_per_second) = (0.0, 0.0, f64::INFINITY);
    }
    for row in &mut zeros.accuracy {
        *row = zero_row(&row.id, &row.workload, row.severity);
    }
    for row in &mut zeros.claims {
        (row.violations, row.of) = (0, 0);
    }
    for row in &mut zeros.tracer {
        (row.mrays_per_second, row.mrays_per_second_mad, row.build_seconds, row.ray_count) = (0.0, 0.0, 0.0, 0);
        row.ns_of_rounds = Samples::default();
    }
    for row in &mut zeros.coherence {
        (row.mrays_per_second, row.mrays_per_second_mad, row.ray_count) = (0.0, 0.0, 0);
        (row.nodes, row.leaves, row.tests, row.lanes) = (0, 0, 0, 0);
    }
    for row in &mut zeros.scaling {
        (row.ns_per_ray, row.ns_per_ray_mad, row.build_seconds, row.triangles, row.ray_count) = (0.0, 0.0, 0.0, 0, 0);
    }
    zeros.kernels = summary::kernels(&zeros);
    for map in &mut zeros.maps {
        (map.x, map.y, map.hits) = (vec![1.0], Vec::new(), Vec::new());
    }
    for regime in &mut zeros.regimes {
        regime.steps = vec![0.0];
    }
    let mut empty = record_of(&[]);
    empty.absent.clear();
    empty.loops.clear();
    empty.regimes.clear();
    empty.maps.clear();
    clear_tracer(&mut empty);
    [bare, zeros, empty]
}

fn clear_tracer(record: &mut Record) {
    record.on_scenes.clear();
    record.scene_speed.clear();
    record.tracer.clear();
    record.coherence.clear();
    record.scaling.clear();
    record.peers.clear();
}

fn regimes() -> Vec<RegimeRow> {
    let tens = |from: i32, to: i32| -> Vec<f64> {
        let exponents: Vec<i32> = if from < to { (from..=to).collect() } else { (to..=from).rev().collect() };
        exponents.into_iter().map(|exponent| 10f64.powi(exponent)).collect()
    };
    let ending_in_zero = |mut steps: Vec<f64>| {
        steps.push(0.0);
        steps
    };
    let scale: Vec<f64> = (-5..=5).map(|step| 10f64.powi(3 * step)).collect();
    let fans = [4.0, 16.0, 64.0, 256.0, 1024.0, 8192.0, 65_536.0].to_vec();
    let rows: [(&str, &str, &str, Vec<f64>, Counts); 27] = [
        ("triangle", "grazing", "angle to the plane (rad)", ending_in_zero(tens(-1, -6)), Counts::Tests),
        ("triangle", "sliver", "length / height of the triangle", tens(1, 6), Counts::Tests),
        ("triangle", "offset", "distance from the origin / size", tens(0, 6), Counts::Tests),
        ("triangle", "distance", "length of the ray / size", tens(0, 5), Counts::Tests),
        ("triangle", "ground", "size / distance of the hit", tens(0, 6), Counts::Tests),
        ("triangle", "scale", "size of triangle and ray (units)", scale.clone(), Counts::Tests),
        (
            "triangle",
            "shared_edge",
            "distance of the aim from the edge / its length",
            ending_in_zero(tens(-2, -8)),
            Counts::Mesh,
        ),
        ("triangle", "vertex_fan", "triangles around the vertex", fans, Counts::Mesh),
        ("triangle", "closed_mesh", "distance of the mesh from the origin / size", tens(0, 5), Counts::Mesh),
        ("triangle", "t_junction", "distance of the aim from the edge / its length", tens(-3, -8), Counts::Mesh),
        ("triangle", "silhouette", "distance from the silhouette / size", tens(-3, -8), Counts::Crossings),
        ("triangle", "depth_order", "angle of the fold (rad)", tens(-2, -7), Counts::Closest),
        ("triangle", "inside_box", "angle to the plane (rad)", tens(0, -6), Counts::Boxes),
        ("aabb", "box_edge", "distance of the aim from the edge / size", ending_in_zero(tens(-2, -8)), Counts::Tests),
        (
            "aabb",
            "box_corner",
            "distance of the aim from the corner / size",
            ending_in_zero(tens(-2, -8)),
            Counts::Tests,
        ),
        ("aabb", "parallel", "angle to the plane (rad)", ending_in_zero(tens(-1, -6)), Counts::Tests),
        ("aabb", "flat", "thickness / size", ending_in_zero(tens(-1, -8)), Counts::Tests),
        ("aabb", "inverted", "how far the bounds are swapped / size", tens(-6, 0), Counts::Tests),
        ("aabb", "offset", "distance from the origin / size", tens(0, 6), Counts::Tests),
        ("aabb", "distance", "length of the ray / size", tens(0, 5), Counts::Tests),
        ("aabb", "scale", "size of box and ray (units)", scale.clone(), Counts::Tests),
        ("quadric", "afar", "length of the ray / radius", tens(1, 6), Counts::Tests),
        ("quadric", "tangent", "distance from the silhouette / radius", tens(-1, -7), Counts::Tests),
        ("quadric", "scale", "size of quadric and ray (units)", scale, Counts::Tests),
        ("instance of triangle", "translation", "distance from the origin / size", tens(0, 6), Counts::Tests),
        ("instance of aabb", "translation", "distance from the origin / size", tens(0, 6), Counts::Tests),
        ("instance of quadric", "translation", "distance from the origin / size", tens(0, 6), Counts::Tests),
    ];
    let row = |(family, name, axis, steps, counts): (&str, &str, &str, Vec<f64>, Counts)| RegimeRow {
        family: family.into(),
        name: name.into(),
        about: format!(
            "Rays aimed into and closely past one primitive, harder with each step of the {axis}. Look for the step \
             from which a kernel is wrong."
        ),
        axis: axis.into(),
        steps,
        mesh: counts == Counts::Mesh,
        counts: counts.name().into(),
    };
    rows.map(row).into()
}

fn maps() -> Vec<MapRow> {
    let severities = |n: i32, decades: f64| (0..n).map(move |i| 10f64.powf(f64::from(i) * decades / f64::from(n - 1)));
    let map = |family: &str, name: &str, x_axis: &str, y_axis: &str| MapRow {
        family: family.into(),
        name: name.into(),
        x_axis: x_axis.into(),
        x: severities(19, 6.0).collect(),
        y_axis: y_axis.into(),
        y: severities(16, 5.0).collect(),
        hits: (0..19 * 16).map(|cell| if cell > 300 { 99 } else { 1024 }).collect(),
    };
    vec![
        map("triangle", "offset-aspect", "distance from the origin / size", "length / height of the triangle"),
        map("triangle", "distance-grazing", "length of the ray / size", "1 / angle to the plane (1/rad)"),
        map("quadric", "distance-silhouette", "length of the ray / radius", "distance from the silhouette / radius"),
        map("aabb", "offset-distance", "distance from the origin / size", "length of the ray / size"),
        map("instance of triangle", "translation-shear", "distance from the origin / size", "condition number"),
    ]
}

fn add_kernel(record: &mut Record, i: usize, id: &str) {
    let mesh = id.contains("triangle");
    record.methods.push(MethodRow {
        id: id.into(),
        family: id.split('/').next().unwrap_or_default().into(),
        idea: format!("idea {i}"),
        source: "Author, \"Title\", 2000".into(),
        operations: OperationCounts {
            mul: 27,
            add: 18,
            compare: 7,
            div: 1,
            fused: 0,
            reads: 9,
            mul_f64: if id.contains("f64") { 27 } else { 0 },
            add_f64: 0,
            compare_f64: 0,
            div_f64: 0,
        },
        prepared_bytes: 36,
        set_bytes: 40_000 + 1000 * i,
        setup_bytes: 12,
        setup_ns: 1.5,
        setup_ns_packet: 0.25,
        claims: if i.is_multiple_of(2) { vec![claims_of(id)[0].into()] } else { Vec::new() },
    });
    let ns = 6.0 * (1.0 + 0.37 * (i % 7) as f64 + 0.05 * i as f64);
    for (width, ns) in [("1x1", ns), ("8x1", ns / (5.1 + 0.3 * (i % 5) as f64)), ("1x8", ns / 5.2)] {
        for threads in [1, 2] {
            let row = speed_row(id, width, threads, ns / (0.95 * threads as f64));
            record.speed.push(SpeedRow { checksum: format!("{i:016x}"), ..row });
        }
    }
    for (workload, rays) in [("generic", 1_000_000), ("edge", 200_000)] {
        let edge = workload == "edge";
        let lost = if edge { [0.0, 51_234.0, 3.5, 840.0][i % 4] } else { 0.0 };
        record.accuracy.push(AccuracyRow {
            rays,
            tests: 8 * rays,
            exact_hits: rays / 4,
            exact_misses: rays / 4,
            false_miss_per_million: lost,
            boundary_none: if edge { 100 * (i as u64 % 4) } else { 0 },
            boundary_one: if edge { rays / 2 } else { 0 },
            mesh_hits: if edge && mesh { rays } else { 0 },
            leak_per_million: lost,
            single_hits: if edge && mesh { rays / 4 } else { 0 },
            agreed_hits: 45_000,
            t_ulp_p99: [2, 4, 0, 44_000, 3][i % 5],
            t_ulp_max: 1 << 20,
            uv_error_p99: 1.3e-7,
            uv_error_max: 2.5e-3,
            hit_errors: hit_errors(i),
            ..zero_row(id, workload, None)
        });
    }
    for (claim, violations) in claims_of(id).iter().zip([i as u64 % 3, 0, 17]) {
        let claimed = i.is_multiple_of(2) && *claim == claims_of(id)[0];
        let violations = if claimed && i != 4 { 0 } else { violations };
        record.claims.push(ClaimRow { id: id.into(), claim: (*claim).into(), claimed, violations, of: 100_000 });
    }
    let family = id.rsplit('/').nth(1).unwrap_or_default();
    let family = if id.starts_with("instance") { format!("instance of {family}") } else { family.into() };
    for regime in record.regimes.iter().filter(|regime| regime.family == family) {
        let rows = regime.steps.iter().enumerate().map(|(step, _)| regime_row(regime, i, id, step));
        record.accuracy.extend(rows);
    }
    for map in record.maps.iter().filter(|map| map.family == family) {
        record.map_cells.push(map_cells(map, i, id));
    }
}

fn claims_of(id: &str) -> &'static [&'static str] {
    match id.rsplit('/').nth(1) {
        Some("triangle") => &["edge-watertight", "vertex-watertight", "single-hit"],
        Some("quadric") => &["right-decision", "no-gross-error"],
        _ => &["conservative"],
    }
}

/// Errors that grow eightfold with each step, from a step on that differs between kernels. Every fourth kernel has
/// none. The regime `scale` is hard at both ends.
fn regime_row(regime: &RegimeRow, i: usize, id: &str, step: usize) -> AccuracyRow {
    let last = regime.steps.len() - 1;
    let hardness = if regime.name == "scale" { (2 * step).abs_diff(last) } else { step };
    let beyond = hardness as f64 - (1.5 + (i % 4) as f64 + 0.1 * i as f64);
    let rate = if i % 4 == 3 || beyond < 0.0 { 0.0 } else { (30.0 * 8f64.powf(beyond)).min(4e5) };
    let rays = 20_000;
    // The rate must correspond to a whole number of events.
    let rate = (rate * rays as f64 / 1e6).floor() / rays as f64 * 1e6;
    let mesh = regime.mesh;
    let counts = |counts: Counts| regime.counts == counts.name();
    // If all rays are lost, there is no error of t.
    let agreed_hits = if i % 4 == 2 && step == last { 0 } else { 9_000 };
    AccuracyRow {
        rays,
        tests: rays,
        exact_hits: 10_000,
        exact_misses: 9_000,
        false_miss_per_million: rate,
        false_hit_per_million: rate / 3.0,
        boundary_none: if rate > 1e4 { 20 } else { 0 },
        boundary_one: 100,
        mesh_hits: if mesh { rays } else { 0 },
        leak_per_million: if mesh && i != 1 { rate / 7.0 } else { 0.0 },
        single_hits: if mesh { rays / 2 } else { 0 },
        double_hit_per_million: if mesh && i % 3 == 1 { rate / 9.0 } else { 0.0 },
        crossing_rays: if counts(Counts::Crossings) { rays } else { 0 },
        odd_per_million: if counts(Counts::Crossings) { rate } else { 0.0 },
        closest_rays: if counts(Counts::Closest) { rays / 2 } else { 0 },
        wrong_closest_per_million: if counts(Counts::Closest) { rate } else { 0.0 },
        box_hits: if counts(Counts::Boxes) { rays / 2 } else { 0 },
        box_rejected_per_million: if counts(Counts::Boxes) { rate / 5.0 } else { 0.0 },
        box_clamped_per_million: if counts(Counts::Boxes) { rate } else { 0.0 },
        agreed_hits,
        t_ulp_p99: if agreed_hits == 0 || i == 8 { 0 } else { (2.0 * 9f64.powf(beyond.max(0.0))) as u64 },
        hit_errors: if agreed_hits == 0 { HitErrors::default() } else { hit_errors(i) },
        ..zero_row(id, &regime.name, Some(regime.steps[step]))
    }
}

/// Errors of points and normals, without those that a quadric lacks. Every third kernel hits what rays leave.
fn hit_errors(i: usize) -> HitErrors {
    let own_hits = [0.0, 125_000.0, 0.0][i % 3];
    HitErrors {
        measured_hits: 1_000,
        ray_point_size_p99: Some(1.25e-7 * 10f64.powi(i as i32 % 5)),
        ray_height_size_p99: Some(0.75e-7),
        normal_error_p99: Some(3.5e-8),
        t_backward_p99: Some(0.5 * (1 + i) as f64),
        leaving_rays: 1_000,
        own_hit_offset_per_million: own_hits / 125.0,
        own_hit_no_epsilon_per_million: 500_000.0,
        ..HitErrors::default()
    }
}

/// Errors that grow along both axes until rays miss, at a speed that depends on the kernel.
fn map_cells(map: &MapRow, i: usize, id: &str) -> MapCells {
    let cell = |(x, y): (f64, f64)| {
        let power = x.log10() * (0.3 + 0.12 * (i % 5) as f64) + y.log10() * (0.2 + 0.15 * (i % 4) as f64);
        (power < 4.5).then(|| (10f64.powf(1.5 * power - 0.5)) as u64)
    };
    let cells = map.y.iter().flat_map(|&y| map.x.iter().map(move |&x| (x, y)));
    MapCells { id: id.into(), map: map.name.clone(), t_ulp_p99: cells.map(cell).collect() }
}

/// A row without any ray.
fn zero_row(id: &str, workload: &str, severity: Option<f64>) -> AccuracyRow {
    AccuracyRow {
        id: id.into(),
        workload: workload.into(),
        severity,
        rays: 0,
        tests: 0,
        exact_hits: 0,
        exact_misses: 0,
        false_miss_per_million: 0.0,
        false_hit_per_million: 0.0,
        boundary_none: 0,
        boundary_one: 0,
        boundary_many: 0,
        mesh_hits: 0,
        leak_per_million: 0.0,
        single_hits: 0,
        double_hit_per_million: 0.0,
        crossing_rays: 0,
        odd_per_million: 0.0,
        closest_rays: 0,
        wrong_closest_per_million: 0.0,
        box_hits: 0,
        box_rejected_per_million: 0.0,
        box_clamped_per_million: 0.0,
        agreed_hits: 0,
        t_ulp_p50: 0,
        t_ulp_p99: 0,
        t_ulp_max: 0,
        gross_per_million: 0.0,
        uv_error_p99: 0.0,
        uv_error_max: 0.0,
        hit_errors: HitErrors::default(),
    }
}

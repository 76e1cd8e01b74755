//! Throw-away.
use raylanes::geom::Triangle;
use raylanes::study::accuracy::Kernels;
use raylanes::study::record::AccuracyRow;
use raylanes::study::workload::{Subject, Workload};
use raylanes::tracer::thread_pool;

#[test]
fn rows() {
    let rays = std::env::var("RAYS").map_or(20_000, |x| x.parse().unwrap());
    let only = std::env::var("ONLY").unwrap_or_default();
    let kernels = Kernels::<Triangle>::registered();
    let show = |rows: Vec<AccuracyRow>| {
        for r in rows.iter().filter(|r| only.is_empty() || only.split(',').any(|o| r.id.ends_with(&format!("/{o}")))) {
            println!("{:14} {:8} {:26} fm {:9.1} fh {:8.1} leak {:8.1} dbl {:8.1} b {}/{}/{} p50 {} p99 {} max {} gross {:.0} uv {:.1e}",
              r.workload, r.severity.map_or(String::new(), |s| format!("{s:e}")), &r.id[9..], r.false_miss_per_million, r.false_hit_per_million,
              r.leak_per_million, r.double_hit_per_million, r.boundary_none, r.boundary_one, r.boundary_many, r.t_ulp_p50, r.t_ulp_p99, r.t_ulp_max, r.gross_per_million, r.uv_error_p99);
        }
    };
    thread_pool(2).unwrap().install(|| {
        for w in Workload::ALL { show(kernels.on_workload(w, rays, 1)); }
        for regime in Triangle::REGIMES {
            for &step in regime.steps { show(kernels.on_regime(regime, step, rays, 1)); }
        }
    });
}

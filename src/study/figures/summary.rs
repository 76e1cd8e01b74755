//! The summary of each kernel: its most important figures, collected from the other rows of a record.

use super::limit::Limit;
use super::rate::{Rate, double_hits, leaks, shares_whole_edges, ulp_p99};
use crate::study::record::{AccuracyRow, KernelRow, MethodRow, Record, SpeedRow};

/// Kernel × width, in one thread. Reads all other rows about kernels, so call it last.
pub(crate) fn kernels(record: &Record) -> Vec<KernelRow> {
    let rows = record.speed.iter().filter(|row| row.threads == 1);
    rows.filter_map(|speed| Some(row(record, record.methods.iter().find(|method| method.id == speed.id)?, speed)))
        .collect()
}

fn row(record: &Record, method: &MethodRow, speed: &SpeedRow) -> KernelRow {
    let rows = || record.accuracy.iter().filter(|row| row.id == method.id);
    let generic = rows().find(|row| row.workload == "generic" && row.severity.is_none());
    let rate = |rate: Option<Rate>| rate.map(Rate::per_million);
    let worst = |figure: fn(&AccuracyRow) -> Option<Rate>| {
        let shared = rows().filter(|row| shares_whole_edges(&row.workload));
        shared.filter_map(figure).map(Rate::per_million).reduce(f64::max)
    };
    let ulp = |figure: fn(&AccuracyRow) -> u64| generic.filter(|row| ulp_p99(row).is_some()).map(figure);
    let lanes = if speed.width == "1x1" { 1 } else { 8 };
    // One ray against eight primitives reads eight numbers wherever eight rays read one.
    let limit = Limit::of(&method.operations, &record.rates).filter(|_| lanes == 8);
    let limit_ns = limit.map(|limit| limit.ns / 8.0);
    KernelRow {
        id: method.id.clone(),
        shape: method.shape().into(),
        width: speed.width.clone(),
        lanes,
        ns_per_test: speed.ns_per_test,
        ns_per_test_low: speed.ns_per_test_low,
        ns_per_test_high: speed.ns_per_test_high,
        tests_per_second: speed.tests_per_second,
        prepared_bytes: method.prepared_bytes,
        setup_ns: if lanes == 1 { method.setup_ns } else { method.setup_ns_packet },
        false_miss_per_million: rate(generic.and_then(|row| Rate::new(row.false_miss_per_million, row.exact_hits))),
        false_hit_per_million: rate(generic.and_then(|row| Rate::new(row.false_hit_per_million, row.exact_misses))),
        leak_per_million: worst(leaks),
        double_hit_per_million: worst(double_hits),
        t_ulp_p50: ulp(|row| row.t_ulp_p50),
        t_ulp_p99: ulp(|row| row.t_ulp_p99),
        t_ulp_max: ulp(|row| row.t_ulp_max),
        claims: method.claims.clone(),
        limit_ns,
        limit_by: limit.map(|limit| limit.class.into()),
        limit_share: limit_ns.map(|ns| ns / speed.ns_per_test).filter(|share| share.is_finite()),
        checksum: speed.checksum.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::fixture::record_of;

    #[test]
    fn a_kernel_has_a_row_for_each_width_with_its_worst_leaks() {
        let mut record =
            record_of(&["triangle/cramer".into(), "aabb/padded".into(), "instance/f64/quadric/stable".into()]);
        for row in &mut record.accuracy {
            (row.leak_per_million, row.false_miss_per_million) = (1.0, 2.0);
            match (row.workload.as_str(), row.severity) {
                ("vertex_fan", Some(256.0)) => row.leak_per_million = 100.0,
                ("t_junction", _) => row.leak_per_million = 110.0,
                ("generic", None) => row.false_miss_per_million = 4.0,
                _ => {}
            }
        }
        let rows = kernels(&record);
        let widths: Vec<_> = rows.iter().map(|row| (row.id.as_str(), row.width.as_str(), row.lanes)).collect();
        let of = |id| [(id, "1x1", 1), (id, "8x1", 8), (id, "1x8", 8)];
        assert_eq!(widths, ["triangle/cramer", "aabb/padded", "instance/f64/quadric/stable"].map(of).concat());
        let [triangle, packet, bounds, instance] = [0, 1, 3, 6].map(|row| &rows[row]);
        assert_eq!((triangle.leak_per_million, triangle.false_miss_per_million), (Some(100.0), Some(4.0)));
        assert_eq!((bounds.leak_per_million, bounds.double_hit_per_million), (None, None));
        assert_eq!((instance.shape.as_str(), bounds.shape.as_str()), ("quadric", "aabb"));
        assert_eq!(
            (triangle.setup_ns, packet.setup_ns),
            (record.methods[0].setup_ns, record.methods[0].setup_ns_packet)
        );
        assert!(triangle.limit_ns.is_none() && packet.limit_by.is_some());
        let share = packet.limit_share.unwrap();
        assert!((share * packet.ns_per_test - packet.limit_ns.unwrap()).abs() < 1e-12 && share > 0.0);
    }
}

//! Groups of kernels that can be compared with each other, and which rays count as lost in each group.

use super::kernel::{Failures, KernelFigures, fastest_of, rows_of, tied};
use super::rate::{Rate, false_or_double, leaks, lost_by_boxes, shares_whole_edges};
use crate::study::record::{AccuracyRow, MethodRow, Record, RegimeRow};

/// Kernels that can be compared: those of one shape. Instances of a shape are a group of their own.
#[derive(Debug)]
pub(crate) struct Group<'a> {
    /// Title, such as `triangle` or `instance of triangle`.
    pub(crate) title: String,
    /// The common beginning of all IDs: whole parts, including the last slash.
    pub(crate) prefix: String,
    /// The title. If several methods of instancing have the same kernel inside, with the name of that kernel: `instance
    /// of triangle/moller_trumbore`. The names of these kernels leave it out.
    pub(crate) subject: String,
    /// The shape that is hit, such as `triangle`. For instances, the shape inside.
    pub(crate) shape: &'a str,
    /// Which rays [`KernelFigures::lost`] counts.
    pub(crate) loss: Loss,
    /// The workloads that decide which kernel is right: their rays are aimed where kernels fail.
    pub(crate) deciding: Vec<&'a str>,
    /// The kernels, in the order of the record.
    pub(crate) kernels: Vec<KernelFigures<'a>>,
}

impl Group<'_> {
    /// The fastest kernel at a width in one thread, and all that tie with it.
    pub(crate) fn fastest(&self, width: &str) -> Vec<&KernelFigures<'_>> {
        fastest_of(self.kernels.iter(), width)
    }

    /// Whether a kernel is one of [`Group::fastest`].
    pub(crate) fn is_among_the_fastest(&self, kernel: &KernelFigures, width: &str) -> bool {
        let rows = self.kernels.iter().filter_map(|kernel| kernel.speed(width, 1));
        let fastest = rows.min_by(|a, b| a.ns_per_test.total_cmp(&b.ns_per_test));
        fastest.zip(kernel.speed(width, 1)).is_some_and(|(fastest, row)| tied(fastest, row))
    }

    /// The title, and in brackets the parts of the IDs that the names leave out, if these differ from the title.
    pub(crate) fn heading(&self) -> String {
        let several_methods = !self.is_base() && !self.prefix.ends_with(&format!("/{}/", self.shape));
        if self.prefix.strip_suffix('/') == Some(self.title.as_str()) {
            self.title.clone()
        } else if several_methods {
            format!("{} ({}…/{}/…)", self.title, self.prefix, self.shape)
        } else {
            format!("{} ({}…)", self.title, self.prefix)
        }
    }

    /// Whether these are kernels of a primitive and not instances.
    pub(crate) fn is_base(&self) -> bool {
        self.title == self.shape
    }

    /// The fastest of the kernels with the fewest wrong answers, and all that tie with it in both. Of kernels with the
    /// fewest wrong answers, those that claim most are preferred: tests hold them to it, also where no regime aims.
    pub(crate) fn safest(&self) -> Vec<&KernelFigures<'_>> {
        let right: Vec<_> = self.kernels.iter().filter(|kernel| self.is_among_the_safest(kernel)).collect();
        let claims = |kernel: &KernelFigures| kernel.method.claims.len();
        let most = right.iter().map(|kernel| claims(kernel)).max();
        fastest_of(right.into_iter().filter(|kernel| Some(claims(kernel)) == most), "8x1")
    }

    /// Whether no kernel of the group has fewer wrong answers, beyond chance.
    pub(crate) fn is_among_the_safest(&self, kernel: &KernelFigures) -> bool {
        let by_rate = |a: &Rate, b: &Rate| a.per_million().total_cmp(&b.per_million());
        let least = self.kernels.iter().filter_map(|kernel| kernel.wrong).min_by(by_rate);
        least.zip(kernel.wrong).is_some_and(|(least, own)| own.ties_with(least))
    }

    /// The meaning of [`KernelFigures::lost`] in words: the lost rays, the base of the rate, and the workloads.
    pub(crate) fn lost_means(&self) -> String {
        let what = match self.loss {
            Loss::Leaks => "leaks per million rays that exactly hit a mesh, edges included",
            Loss::WithBoundary => "lost rays (false misses and missed boundary hits) per million that exactly hit",
            Loss::Strict => "lost rays (false misses) per million that exactly hit, boundary hits excluded",
        };
        format!("{what}; all rays of {}", self.deciding.join(", "))
    }
}

/// Which rays count as lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Loss {
    /// Rays that hit a mesh and are reported to miss all of it. A neighbour may catch what one triangle loses.
    Leaks,
    /// Rays that hit and are reported to miss, on the boundary too: nothing else would catch them.
    WithBoundary,
    /// Rays that hit and are reported to miss, without those on the boundary: the silhouette of a curved surface is no
    /// edge that another surface shares.
    Strict,
}

impl Loss {
    /// The definition for a shape; `mesh` says whether its kernels were tested on meshes.
    fn for_shape(shape: &str, mesh: bool) -> Self {
        match (shape, mesh) {
            (_, true) => Self::Leaks,
            ("quadric", _) => Self::Strict,
            _ => Self::WithBoundary,
        }
    }

    /// The rate of lost rays in a row.
    pub(crate) fn rate(self, row: &AccuracyRow) -> Option<Rate> {
        match self {
            Self::Leaks => leaks(row),
            Self::WithBoundary => lost_by_boxes(row),
            Self::Strict => Rate::new(row.false_miss_per_million, row.exact_hits),
        }
    }

    /// The rate of rays in a row that are lost, or hit falsely or twice. Each ray counts once.
    fn wrong(self, row: &AccuracyRow) -> Option<Rate> {
        let (lost, false_hits) = (self.rate(row), false_or_double(row));
        match self {
            // A false hit of a bounding box only costs a look inside.
            Self::WithBoundary => lost,
            // Rays that hit one triangle strictly inside are among those that hit the mesh.
            Self::Leaks if row.mesh_hits > 0 => {
                let twice = false_hits.map_or(0, |rate| rate.events);
                lost.map(|lost| Rate { events: lost.events + twice, of: lost.of })
            }
            Self::Leaks => false_hits,
            Self::Strict => Rate::sum([lost, false_hits].into_iter().flatten()),
        }
    }

    /// Whether the rays of a regime are aimed where rays can be lost in this way.
    fn concerns(self, regime: &RegimeRow) -> bool {
        let one_of = |names: &[&str]| names.contains(&regime.name.as_str());
        match self {
            Self::Leaks => regime.name == "leaving" || regime.mesh && shares_whole_edges(&regime.name),
            Self::WithBoundary => one_of(&["box_edge", "box_corner", "parallel", "flat"]),
            Self::Strict => one_of(&["afar", "tangent", "parabolic", "generatrix"]),
        }
    }
}

/// The ID of the kernel inside an instance: `family/method` in `instance/method/family/method`. `None` for other
/// kernels.
fn inner(id: &str) -> Option<&str> {
    id.splitn(3, '/').nth(2)
}

/// The family of the kernel inside an instance.
fn inner_family(id: &str) -> Option<&str> {
    inner(id).and_then(|inner| inner.split('/').next())
}

impl MethodRow {
    /// The shape that is hit: the kernel's family, or for an instance the family of the kernel inside.
    pub(crate) fn shape(&self) -> &str {
        inner_family(&self.id).unwrap_or(&self.family)
    }
}

/// The kernels of a record in groups, in the order of the record.
pub(crate) fn groups(record: &Record) -> Vec<Group<'_>> {
    let mut groups: Vec<(&str, Option<&str>, Vec<&MethodRow>)> = Vec::new();
    for kernel in &record.methods {
        let key = (kernel.family.as_str(), inner_family(&kernel.id));
        match groups.iter_mut().find(|(family, inner, _)| (*family, *inner) == key) {
            Some((.., kernels)) => kernels.push(kernel),
            None => groups.push((key.0, key.1, vec![kernel])),
        }
    }
    groups.into_iter().map(|(family, inner, kernels)| group(record, family, inner, &kernels)).collect()
}

fn group<'a>(record: &'a Record, family: &'a str, inner: Option<&'a str>, kernels: &[&'a MethodRow]) -> Group<'a> {
    let title = inner.map_or(family.to_owned(), |inner| format!("{family} of {inner}"));
    let shape = inner.unwrap_or(family);
    let shared = kernels.iter().filter_map(|kernel| self::inner(&kernel.id)).find(|inner| {
        let with_it = kernels.iter().filter(|kernel| self::inner(&kernel.id) == Some(inner));
        with_it.count() > 1
    });
    let subject = shared.map_or(title.clone(), |inner| format!("{family} of {inner}"));
    let prefix = common_prefix(kernels);
    let name = |kernel: &MethodRow| {
        let own = &kernel.id[prefix.len()..];
        let method = shared.and_then(|inner| own.strip_suffix(inner)?.strip_suffix('/'));
        method.map_or_else(|| own.replace(&format!("/{shape}/"), "/"), str::to_owned)
    };
    let mesh = kernels.iter().any(|kernel| rows_of(record, &kernel.id).any(|row| row.mesh_hits > 0));
    let loss = Loss::for_shape(shape, mesh);
    let deciding = deciding_workloads(record, shape, loss, kernels);
    let kernels = kernels
        .iter()
        .map(|&kernel| {
            let decides = |row: &AccuracyRow| deciding.contains(&row.workload.as_str());
            let rows = || rows_of(record, &kernel.id).filter(|row| shares_whole_edges(&row.workload));
            KernelFigures {
                method: kernel,
                name: name(kernel),
                lost: Failures::over(rows(), decides, |row| loss.rate(row)),
                false_hits: Failures::over(rows(), decides, false_or_double),
                wrong: Rate::sum(rows().filter(|row| decides(row)).filter_map(|row| loss.wrong(row))),
                record,
            }
        })
        .collect();
    Group { title, prefix: prefix.to_owned(), subject, shape, loss, deciding, kernels }
}

/// The workloads whose rays are aimed where kernels fail.
fn deciding_workloads<'a>(record: &'a Record, shape: &str, loss: Loss, kernels: &[&MethodRow]) -> Vec<&'a str> {
    let loses = |regime: &&RegimeRow| regime.family == shape && loss.concerns(regime);
    let measured =
        |workload: &&str| kernels.iter().any(|kernel| rows_of(record, &kernel.id).any(|row| row.workload == *workload));
    let regimes = record.regimes.iter().filter(loses).map(|regime| regime.name.as_str());
    ["edge"].into_iter().chain(regimes).filter(measured).collect()
}

/// The longest common beginning of the IDs that ends with a slash.
fn common_prefix<'a>(kernels: &[&'a MethodRow]) -> &'a str {
    let first = kernels[0].id.as_str();
    let mut ends = first.match_indices('/').map(|(slash, _)| &first[..=slash]);
    ends.rfind(|prefix| kernels.iter().all(|kernel| kernel.id.starts_with(prefix))).unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::fixture::{all_ids, record_of, set_rounds};

    #[test]
    fn a_box_loses_strict_hits_and_boundary_hits() {
        let mut record = record_of(&["aabb/division".into()]);
        record.accuracy.retain(|row| row.severity.is_none());
        let row = record.accuracy.iter_mut().find(|row| row.workload == "edge").unwrap();
        (row.exact_hits, row.false_miss_per_million) = (1000, 5000.0);
        (row.boundary_none, row.boundary_one, row.boundary_many) = (45, 955, 0);
        let lost = groups(&record)[0].kernels[0].lost.unwrap();
        assert_eq!(Some(lost.rate), Rate::of_events(50, 2000));
    }

    #[test]
    fn workloads_aimed_at_failures_decide_all_together() {
        let mut record = record_of(&["triangle/cramer".into(), "aabb/division".into()]);
        for row in &mut record.accuracy {
            (row.leak_per_million, row.false_miss_per_million, row.boundary_none) = (0.0, 0.0, 0);
            let worst = if row.mesh_hits > 0 { ("vertex_fan", Some(256.0)) } else { ("flat", Some(0.0)) };
            if (row.workload.as_str(), row.severity) == worst {
                (row.leak_per_million, row.false_miss_per_million) = (70.0, 100.0);
            }
            // Two workloads are not aimed at edges, and the mesh of the third one is at fault. None of them counts.
            if ["generic", "offset", "t_junction"].contains(&row.workload.as_str()) {
                (row.leak_per_million, row.false_miss_per_million) = (1e5, 1e5);
            }
        }
        let groups = groups(&record);
        assert_eq!(groups[0].deciding, ["edge", "shared_edge", "vertex_fan", "closed_mesh"]);
        assert_eq!(groups[1].deciding, ["edge", "box_edge", "box_corner", "parallel", "flat"]);
        let [triangle, bounds] = [0, 1].map(|group: usize| &groups[group].kernels[0]);
        let lost = triangle.lost.unwrap();
        let aimed = |row: &&AccuracyRow| row.id == "triangle/cramer" && shares_whole_edges(&row.workload);
        let all = record.accuracy.iter().filter(aimed).map(|row| row.mesh_hits).sum();
        assert_eq!(lost.rate, Rate { events: 1, of: all });
        let (row, worst) = lost.worst.unwrap();
        assert_eq!((row.severity, worst), (Some(256.0), Rate::new(70.0, 20_000).unwrap()));
        let lost = bounds.lost.unwrap();
        // The worst workload is named, also if it does not decide.
        assert_eq!((lost.rate.events, lost.worst.unwrap().0.workload.as_str()), (1, "generic"));
    }

    #[test]
    fn a_kernel_that_always_hits_is_not_the_safest() {
        let mut record = record_of(&["triangle/always".into(), "triangle/right".into(), "triangle/tied".into()]);
        for row in &mut record.accuracy {
            (row.leak_per_million, row.double_hit_per_million) = (0.0, 0.0);
            match row.id.as_str() {
                "triangle/always" => row.double_hit_per_million = 1e6,
                // One event in all of these rays is no difference.
                "triangle/tied" if row.workload == "edge" => row.leak_per_million = 1e6 / row.mesh_hits as f64,
                _ => {}
            }
        }
        record.methods.iter_mut().for_each(|method| method.claims.clear());
        for row in &mut record.speed {
            let ns = if row.id == "triangle/always" { 1.0 } else { 2.0 };
            set_rounds(row, &[0.99, 1.0, 1.01].map(|noise| noise * ns));
        }
        let groups = groups(&record);
        let names: Vec<_> = groups[0].safest().iter().map(|kernel| kernel.name.as_str()).collect();
        assert_eq!(names, ["right", "tied"]);
        let wrong = |kernel: usize| groups[0].kernels[kernel].wrong.unwrap().events;
        assert!(wrong(0) > 10_000 && wrong(1) == 0 && wrong(2) == 1);
        // Between equals, the one that claims more.
        record.methods[2].claims.push("edge-watertight".into());
        let groups = super::groups(&record);
        assert_eq!(groups[0].safest().iter().map(|kernel| kernel.name.as_str()).collect::<Vec<_>>(), ["tied"]);
    }

    #[test]
    fn the_safest_has_the_least_rate_and_not_the_fewest_events() {
        let mut record = record_of(&["triangle/many".into(), "triangle/few".into()]);
        for row in &mut record.accuracy {
            (row.leak_per_million, row.double_hit_per_million) = (0.0, 0.0);
            match (row.id.as_str(), row.workload.as_str()) {
                // 10 in all rays.
                ("triangle/many", "edge") => row.leak_per_million = 10e6 / row.mesh_hits as f64,
                // 5 in 100.
                ("triangle/few", "edge") => (row.mesh_hits, row.leak_per_million, row.single_hits) = (100, 5e4, 0),
                ("triangle/few", _) => (row.mesh_hits, row.exact_misses) = (0, 0),
                _ => {}
            }
        }
        let groups = groups(&record);
        let kernels = &groups[0].kernels;
        assert_eq!([0, 1].map(|kernel: usize| kernels[kernel].lost.unwrap().rate.events), [10, 5]);
        assert_eq!([0, 1].map(|kernel: usize| groups[0].is_among_the_safest(&kernels[kernel])), [true, false]);
    }

    #[test]
    fn all_that_tie_with_the_fastest_are_among_the_fastest() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into(), "triangle/c".into()]);
        for row in &mut record.speed {
            let ns = if row.id == "triangle/c" { 2.0 } else { 1.0 };
            set_rounds(row, &[0.99, 1.0, 1.01].map(|noise| noise * ns));
        }
        let groups = groups(&record);
        let group = &groups[0];
        assert_eq!(group.fastest("8x1").iter().map(|kernel| kernel.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
        let fastest = group.kernels.iter().map(|kernel| group.is_among_the_fastest(kernel, "8x1"));
        assert_eq!(fastest.collect::<Vec<_>>(), [true, true, false]);
    }

    #[test]
    fn regimes_decide_if_their_rays_are_aimed_where_rays_are_lost() {
        let regime = |mesh, name: &str| {
            let record = record_of(&[]);
            RegimeRow { name: name.into(), mesh, ..record.regimes[0].clone() }
        };
        let aimed = |loss: Loss, mesh, names: &[&'static str]| {
            names.iter().copied().filter(|name| loss.concerns(&regime(mesh, name))).collect::<Vec<_>>()
        };
        assert_eq!(aimed(Loss::Leaks, true, &["vertex_fan", "t_junction"]), ["vertex_fan"]);
        assert_eq!(aimed(Loss::Leaks, false, &["leaving", "offset"]), ["leaving"]);
        let curved = ["afar", "tangent", "parabolic", "generatrix"];
        assert_eq!(aimed(Loss::Strict, false, &[&curved[..], &["scale", "rim"]].concat()), curved);
        let boxes = ["box_edge", "box_corner", "parallel", "flat"];
        assert_eq!(aimed(Loss::WithBoundary, false, &[&boxes[..], &["inverted", "offset"]].concat()), boxes);
    }

    #[test]
    fn instances_are_grouped_by_the_shape_inside() {
        let record = record_of(&all_ids());
        let groups = groups(&record);
        let titles: Vec<_> = groups.iter().map(|group| group.title.as_str()).collect();
        assert_eq!(
            titles,
            ["triangle", "aabb", "quadric", "instance of triangle", "instance of aabb", "instance of quadric"]
        );
        assert_eq!(groups[3].prefix, "instance/");
        assert_eq!(groups[3].heading(), "instance of triangle (instance/…/triangle/…)");
        let losses = groups.iter().map(|group| group.loss);
        let each = [Loss::Leaks, Loss::WithBoundary, Loss::Strict];
        assert!(losses.eq(each.into_iter().chain(each)));
    }

    #[test]
    fn names_leave_out_the_kernel_that_several_methods_have_inside() {
        let record = record_of(&all_ids());
        let groups = groups(&record);
        let names = |group: usize| groups[group].kernels.iter().map(|kernel| kernel.name.as_str()).collect::<Vec<_>>();
        assert_eq!(names(2), ["naive", "stable", "mixed", "f64"]);
        assert_eq!(names(3), ["subtract_first", "inverse", "f64", "baked", "subtract_first/exact"]);
        assert_eq!([4, 5].map(names), [["subtract_first", "inverse", "f64"]; 2]);
        let subjects = [2, 3, 4, 5].map(|group: usize| groups[group].subject.as_str());
        let of_triangles = "instance of triangle/moller_trumbore";
        assert_eq!(subjects, ["quadric", of_triangles, "instance of aabb/padded", "instance of quadric/stable"]);
    }
}

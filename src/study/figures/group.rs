//! Groups of kernels that can be compared with each other, and which rays count as lost in each group.

use super::kernel::{KernelFigures, fastest_of, rows_of};
use super::rate::{Rate, leaks, lost_by_boxes, shares_whole_edges};
use crate::study::record::{AccuracyRow, MethodRow, Record, RegimeRow};

/// Kernels that can be compared: those of one shape. Instances of a shape are a group of their own.
#[derive(Debug)]
pub(crate) struct Group<'a> {
    /// Title, such as `triangle` or `instance of triangle`.
    pub(crate) title: String,
    /// The common beginning of all IDs: whole parts, including the last slash.
    pub(crate) prefix: String,
    /// The title. If all are instances of the same kernel, the name of that kernel: `instance of
    /// triangle/moller_trumbore`.
    pub(crate) subject: String,
    /// The shape that is hit, such as `triangle`. For instances, the shape inside.
    pub(crate) shape: &'a str,
    /// Which rays [`KernelFigures::lost`] counts.
    pub(crate) loss: Loss,
    /// The workloads that [`KernelFigures::lost`] takes the worst of.
    pub(crate) loss_workloads: Vec<&'a str>,
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
        self.fastest(width).iter().any(|best| best.method.id == kernel.method.id)
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

    /// The meaning of [`KernelFigures::lost`] in words: the lost rays, the base of the rate, and the workloads.
    pub(crate) fn lost_means(&self) -> String {
        let what = match self.loss {
            Loss::Leaks => "leaks per million rays that exactly hit a mesh, edges included",
            Loss::WithBoundary => "lost rays (false misses and missed boundary hits) per million that exactly hit",
            Loss::Strict => "lost rays (false misses) per million that exactly hit, boundary hits excluded",
        };
        let worst = if self.loss_workloads.len() > 1 { "worst of" } else { "on" };
        format!("{what}; {worst} {}", self.loss_workloads.join(", "))
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
    pub(crate) const ALL: [Self; 3] = [Self::Leaks, Self::WithBoundary, Self::Strict];

    /// The definition for a shape; `mesh` says whether its kernels were tested on meshes.
    fn for_shape(shape: &str, mesh: bool) -> Self {
        match (shape, mesh) {
            (_, true) => Self::Leaks,
            ("quadric", _) => Self::Strict,
            _ => Self::WithBoundary,
        }
    }

    /// The rate of lost rays in a row.
    fn rate(self, row: &AccuracyRow) -> Option<Rate> {
        match self {
            Self::Leaks => leaks(row),
            Self::WithBoundary => lost_by_boxes(row),
            Self::Strict => Rate::new(row.false_miss_per_million, row.exact_hits),
        }
    }

    /// Whether the rays of a regime are aimed where rays can be lost in this way.
    fn concerns(self, regime: &RegimeRow) -> bool {
        let one_of = |names: &[&str]| names.contains(&regime.name.as_str());
        match self {
            Self::Leaks => regime.mesh && shares_whole_edges(&regime.name),
            Self::WithBoundary => one_of(&["box_edge", "box_corner", "parallel", "flat"]),
            Self::Strict => one_of(&["afar", "tangent", "parabolic", "generatrix"]),
        }
    }
}

/// The kernels of a record in groups, in the order of the record.
pub(crate) fn groups(record: &Record) -> Vec<Group<'_>> {
    grouped(record, record.methods.iter())
}

/// Like [`groups`], but an instance is kept only if several methods of instancing have its inner kernel. Regimes and
/// maps of instances are about the transform, so they compare methods with the same kernel inside.
pub(crate) fn groups_of_methods(record: &Record) -> Vec<Group<'_>> {
    let is_of_several = |kernel: &&MethodRow| match inner(&kernel.id) {
        Some(own) => record.methods.iter().filter(|other| inner(&other.id) == Some(own)).count() > 1,
        None => true,
    };
    grouped(record, record.methods.iter().filter(is_of_several))
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

fn grouped<'a>(record: &'a Record, kernels: impl Iterator<Item = &'a MethodRow>) -> Vec<Group<'a>> {
    let mut groups: Vec<(&str, Option<&str>, Vec<&MethodRow>)> = Vec::new();
    for kernel in kernels {
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
    let own =
        self::inner(&kernels[0].id).filter(|own| kernels.iter().all(|kernel| self::inner(&kernel.id) == Some(own)));
    let subject = own.map_or(title.clone(), |own| format!("{family} of {own}"));
    let prefix = common_prefix(kernels);
    let suffix = common_suffix(kernels, prefix);
    let mesh = kernels.iter().any(|kernel| rows_of(record, &kernel.id).any(|row| row.mesh_hits > 0));
    let loss = Loss::for_shape(shape, mesh);
    let loss_workloads = workloads_aimed_at_losses(record, shape, loss, kernels);
    let kernels = kernels
        .iter()
        .map(|&kernel| {
            let rows = rows_of(record, &kernel.id).filter(|row| loss_workloads.contains(&row.workload.as_str()));
            let rates = rows.filter_map(|row| Some((loss.rate(row)?, row)));
            let rates: Vec<(Rate, &AccuracyRow)> = rates.collect();
            let worst = rates.iter().max_by(|(a, _), (b, _)| a.per_million.total_cmp(&b.per_million));
            // If no ray was lost anywhere, the zero is about all of these rays.
            let all = rates.iter().map(|(rate, _)| rate.of).sum();
            let lost = worst.map(|(rate, _)| if rate.per_million == 0.0 { Rate { of: all, ..*rate } } else { *rate });
            KernelFigures {
                method: kernel,
                name: kernel.id[prefix.len()..kernel.id.len() - suffix.len()].replace(&format!("/{shape}/"), "/"),
                lost,
                lost_in: worst.filter(|(rate, _)| rate.per_million > 0.0).map(|&(_, row)| row),
                record,
            }
        })
        .collect();
    Group { title, prefix: prefix.to_owned(), subject, shape, loss, loss_workloads, kernels }
}

/// The workloads whose rays are aimed where a kernel may lose rays.
fn workloads_aimed_at_losses<'a>(record: &'a Record, shape: &str, loss: Loss, kernels: &[&MethodRow]) -> Vec<&'a str> {
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

/// The longest common ending of the IDs, after the prefix, that begins with a slash.
fn common_suffix<'a>(kernels: &[&'a MethodRow], prefix: &str) -> &'a str {
    let first = &kernels[0].id[prefix.len()..];
    let mut starts = first.match_indices('/').map(|(slash, _)| &first[slash..]);
    starts.find(|suffix| kernels.iter().all(|kernel| kernel.id[prefix.len()..].ends_with(suffix))).unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::fixture::{all_ids, record_of};

    #[test]
    fn a_box_loses_strict_hits_and_boundary_hits() {
        let mut record = record_of(&["aabb/division".into()]);
        record.accuracy.retain(|row| row.severity.is_none());
        let row = record.accuracy.iter_mut().find(|row| row.workload == "edge").unwrap();
        (row.exact_hits, row.false_miss_per_million) = (1000, 5000.0);
        (row.boundary_none, row.boundary_one, row.boundary_many) = (45, 955, 0);
        let lost = groups(&record)[0].kernels[0].lost.unwrap();
        assert_eq!((lost.events(), lost.of), (50.0, 2000));
    }

    #[test]
    fn lost_rays_come_from_the_worst_workload_aimed_at_losses() {
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
        assert_eq!(groups[0].loss_workloads, ["edge", "shared_edge", "vertex_fan", "closed_mesh"]);
        assert_eq!(groups[1].loss_workloads, ["edge", "box_edge", "box_corner", "parallel", "flat"]);
        let [triangle, bounds] = [0, 1].map(|group: usize| &groups[group].kernels[0]);
        assert_eq!(triangle.lost, Rate::new(70.0, 20_000));
        assert_eq!(triangle.lost_in.map(|row| row.severity), Some(Some(256.0)));
        assert!(bounds.lost.is_some_and(|lost| (lost.events() - 1.0).abs() < 1e-9));
        assert_eq!(bounds.lost_in.map(|row| row.workload.as_str()), Some("flat"));
    }

    #[test]
    fn a_zero_of_lost_rays_counts_all_rays() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.accuracy.iter_mut().for_each(|row| row.leak_per_million = 0.0);
        let counted = record.accuracy.iter().filter(|row| shares_whole_edges(&row.workload));
        let all = counted.map(|row| row.mesh_hits).sum();
        let kernel = &groups(&record)[0].kernels[0];
        assert!(all > 200_000 && kernel.lost_in.is_none());
        assert_eq!(kernel.lost, Rate::new(0.0, all));
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
        assert_eq!((groups[3].prefix.as_str(), groups[3].kernels.len()), ("instance/", 12));
        assert_eq!(groups[3].kernels[1].name, "subtract_first/moller_trumbore");
        assert_eq!(groups[3].heading(), "instance of triangle (instance/…/triangle/…)");
        let losses = groups.iter().map(|group| group.loss);
        let each = [Loss::Leaks, Loss::WithBoundary, Loss::Strict];
        assert!(losses.eq(each.into_iter().chain(each)));
    }

    #[test]
    fn methods_of_instancing_are_compared_with_the_same_kernel_inside() {
        let record = record_of(&all_ids());
        let names = |group: &Group| group.kernels.iter().map(|kernel| kernel.name.clone()).collect::<Vec<_>>();
        let (groups, methods) = (groups(&record), groups_of_methods(&record));
        assert_eq!([0, 1, 2].map(|base| names(&methods[base])), [0, 1, 2].map(|base| names(&groups[base])));
        assert_eq!(methods[3].title, "instance of triangle");
        assert_eq!(methods[3].subject, "instance of triangle/moller_trumbore");
        assert_eq!([&methods[0].subject, &groups[3].subject], ["triangle", "instance of triangle"]);
        assert_eq!(names(&methods[3]), ["subtract_first", "inverse", "f64", "baked"]);
        assert_eq!(names(&methods[4]), ["subtract_first", "inverse", "f64"]);
        // A single method has nothing to be compared with.
        let record = record_of(&["triangle/cramer".into(), "instance/subtract_first/triangle/cramer".into()]);
        assert_eq!(groups_of_methods(&record).len(), 1);
    }
}

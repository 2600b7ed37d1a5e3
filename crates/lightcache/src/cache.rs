//! Records in an octree: which of them are valid at a point, and with which weights [slides 8, 11].

use gi_core::math::Bounds;

use crate::octree::{Cone, Octree};
use crate::options::Weights;
use crate::site::{Query, Site, Sited};

/// How records near a point are chosen and weighted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighing {
    /// The accuracy a: a record is valid where its relative error is below a [slide 11].
    pub accuracy: f32,
    /// How the weight falls with the error.
    pub weights: Weights,
    /// How much larger than a neighbour's a radius may be, as a fraction of the distance between the two records.
    /// `None`: neighbours do not limit each other.
    pub slope: Option<f32>,
}

/// Records, ready for lookups.
#[derive(Clone, Debug)]
pub struct Cache<R> {
    records: Vec<R>,
    tree: Octree,
    how: Weighing,
}

impl<R: Sited> Cache<R> {
    /// An empty cache for a scene in `bounds`.
    pub fn new(bounds: Bounds, how: Weighing) -> Self {
        Cache { records: Vec::new(), tree: Octree::new(bounds), how }
    }

    /// All records, in the order of insertion.
    pub fn records(&self) -> &[R] {
        &self.records
    }

    /// The octree of the records' positions.
    pub fn tree(&self) -> &Octree {
        &self.tree
    }

    /// How records are chosen and weighted.
    pub fn weighing(&self) -> &Weighing {
        &self.how
    }

    /// Add a record. It and its neighbours limit each other's radii: no radius exceeds a neighbour's by more than
    /// `slope` times the distance between the two \[Krivanek06\].
    pub fn insert(&mut self, mut record: R) {
        if let Some(slope) = self.how.slope {
            let site = record.site_mut();
            site.limit(self.tree.cone_at(site.p, slope).max(site.least));
            let Cache { records, tree, .. } = self;
            let mut lowered = Vec::new();
            let least = |id: u32| records[id as usize].site().least;
            tree.lower(&Cone { p: site.p, radius: site.reach(), slope }, &least, &mut |id, r| {
                lowered.push((id, r))
            });
            lowered.into_iter().for_each(|(id, r)| records[id as usize].site_mut().limit(r));
        }
        let site = record.site();
        self.tree.insert(site.p, site.reach());
        self.records.push(record);
    }

    /// Call `take` with every record that is valid at `q`, and with its weight w_i [slide 11]. `slack` (1 or more)
    /// multiplies the allowed error. `is_visible` is called last: it may trace a ray between the record and `q`.
    #[inline]
    pub fn for_each_valid(
        &self,
        q: &Query,
        slack: f32,
        mut is_visible: impl FnMut(&Site) -> bool,
        mut take: impl FnMut(&R, f32),
    ) {
        self.tree.visit(q.p, slack, |id| {
            let record = &self.records[id as usize];
            let site = record.site();
            let error = site.error(q, self.how.accuracy) / slack;
            if error >= 1.0 || site.is_in_front_of(q) || !is_visible(site) {
                return;
            }
            let weight = match self.how.weights {
                Weights::Smooth => 1.0 - error,
                // The limit keeps the weight finite at the record itself, where the record outweighs all others.
                Weights::Lecture => 1.0 / error.max(LEAST_ERROR),
            };
            take(record, weight);
        });
    }

    /// Whether any record is valid at `q`.
    pub fn has_valid(&self, q: &Query, is_visible: impl FnMut(&Site) -> bool) -> bool {
        let mut found = false;
        self.for_each_valid(q, 1.0, is_visible, |_, _| found = true);
        found
    }

    /// The weight w_j of record `j` at `q` in the lecture's units, 1 / error [slide 11].
    pub fn lecture_weight(&self, j: usize, q: &Query) -> f32 {
        1.0 / (self.records[j].site().error(q, self.how.accuracy) * self.how.accuracy)
    }
}

/// Smallest error that `Weights::Lecture` divides by.
const LEAST_ERROR: f32 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gradients::Gradient;
    use crate::record::{Gradients, Record};
    use gi_core::math::Rgb;
    use gi_core::rng::Pcg;
    use glam::Vec3;

    /// The interpolation that the techniques write: sum w_i E_i / sum w_i [slide 11].
    fn interpolate(
        cache: &Cache<Record>,
        q: &Query,
        is_visible: impl FnMut(&Site) -> bool,
    ) -> Option<Rgb> {
        let (mut sum, mut weights) = (Rgb::BLACK, 0.0);
        cache.for_each_valid(q, 1.0, is_visible, |record, weight| {
            sum += record.extrapolate(q, Gradients::Both) * weight;
            weights += weight;
        });
        (weights > 0.0).then(|| sum / weights)
    }

    fn record(p: Vec3, e: Rgb, radius: f32) -> Record {
        let gradient = Gradient::default();
        let site =
            Site { n: Vec3::Z, p, radii: [radius; 2], axis: Vec3::X, least: 0.0, clear: 1.0 };
        Record { e, site, rotational: gradient, translational: gradient }
    }

    fn cache(weights: Weights, slope: Option<f32>) -> Cache<Record> {
        let how = Weighing { accuracy: 0.1, weights, slope };
        Cache::new(Bounds { min: Vec3::ZERO, max: Vec3::ONE }, how)
    }

    fn at(p: Vec3) -> Query {
        Query { p, n: Vec3::Z }
    }

    #[test]
    fn a_record_interpolates_to_itself_and_a_constant_field_to_the_constant() {
        for weights in [Weights::Lecture, Weights::Smooth] {
            let mut one = cache(weights, None);
            let e = Rgb::new(1.0, 2.0, 3.0);
            one.insert(record(Vec3::splat(0.5), e, 0.2));
            assert_eq!(interpolate(&one, &at(Vec3::splat(0.5)), |_| true), Some(e));
            let mut many = cache(weights, None);
            let mut rng = Pcg::new(1, 0);
            let mut point = || Vec3::new(rng.next_f32(), rng.next_f32(), 0.5);
            (0..400).for_each(|_| many.insert(record(point(), e, 0.15)));
            for _ in 0..200 {
                let found = interpolate(&many, &at(point()), |_| true).expect("covered");
                assert!((found.g - 2.0).abs() < 1e-5, "{found:?}");
            }
        }
    }

    #[test]
    fn at_its_own_point_a_record_outweighs_all_others_with_the_lectures_weight() {
        let mut c = cache(Weights::Lecture, None);
        c.insert(record(Vec3::splat(0.5), Rgb::WHITE, 0.2));
        c.insert(record(Vec3::new(0.6, 0.5, 0.5), Rgb::grey(9.0), 0.2));
        let e = interpolate(&c, &at(Vec3::splat(0.5)), |_| true).expect("covered");
        assert!((e.g - 1.0).abs() < 1e-4, "{e:?}");
    }

    #[test]
    fn octree_and_scan_give_the_same_irradiance() {
        let mut c = cache(Weights::Smooth, Some(0.3));
        let mut rng = Pcg::new(7, 0);
        for _ in 0..500 {
            let p = Vec3::new(rng.next_f32(), rng.next_f32(), 0.5 + 0.01 * rng.next_f32());
            c.insert(record(p, Rgb::grey(rng.next_f32()), 0.02 + 0.1 * rng.next_f32()));
        }
        for _ in 0..500 {
            let q = at(Vec3::new(rng.next_f32(), rng.next_f32(), 0.5));
            let (mut sum, mut weights) = (0.0f64, 0.0f64);
            for r in c.records() {
                let error = r.site.error(&q, 0.1);
                if error < 1.0 && !r.site.is_in_front_of(&q) {
                    sum += f64::from(1.0 - error) * f64::from(r.e.g);
                    weights += f64::from(1.0 - error);
                }
            }
            match interpolate(&c, &q, |_| true) {
                Some(e) => assert!((f64::from(e.g) - sum / weights).abs() < 1e-5),
                None => assert_eq!(weights, 0.0),
            }
        }
    }

    #[test]
    fn records_with_another_normal_or_in_front_of_the_query_are_not_used() {
        let mut c = cache(Weights::Smooth, None);
        c.insert(record(Vec3::splat(0.5), Rgb::WHITE, 0.2));
        let home = Vec3::splat(0.5);
        let turned = |n: Vec3| interpolate(&c, &Query { p: home, n }, |_| true);
        assert!(turned(Vec3::new(0.05, 0.0, 1.0).normalize()).is_some());
        assert!(turned(Vec3::X).is_none() && turned(-Vec3::Z).is_none());
        // Below the record's plane, as on a lower step: the record's surface may shade this point.
        assert!(interpolate(&c, &at(home - Vec3::Z * 0.05), |_| true).is_none());
        assert!(interpolate(&c, &at(home + Vec3::Z * 0.05), |_| true).is_some());
        assert!(interpolate(&c, &at(home), |_| false).is_none(), "hidden");
    }

    #[test]
    fn neighbours_clamp_each_other_whatever_the_order() {
        let (near, far) = (
            record(Vec3::new(0.2, 0.5, 0.5), Rgb::WHITE, 0.02),
            record(Vec3::splat(0.5), Rgb::WHITE, 0.3),
        );
        for order in [[near, far], [far, near]] {
            let mut c = cache(Weights::Smooth, Some(0.1));
            order.into_iter().for_each(|r| c.insert(r));
            let mut radii: Vec<f32> = c.records().iter().map(|r| r.site.reach()).collect();
            radii.sort_by(f32::total_cmp);
            assert_eq!(radii[0], 0.02);
            assert!((radii[1] - 0.05).abs() < 1e-6, "0.02 + 0.1 * 0.3, not {}", radii[1]);
        }
        let mut c = cache(Weights::Smooth, Some(0.1));
        c.insert(Record { site: Site { least: 0.1, ..far.site }, ..far });
        c.insert(near);
        assert_eq!(c.records()[0].site.reach(), 0.1, "not below the least radius");
    }
}

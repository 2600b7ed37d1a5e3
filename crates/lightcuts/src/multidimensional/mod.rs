//! Multidimensional lightcuts \[Walter06\]: one cut for all camera paths of a pixel.
//!
//! | | |
//! |---|---|
//! | estimate | L(pixel) = sum over the pairs (G, C) of a cut of S(G) f(x) G(x, y) V(x, y) power(C): G is a cluster of gather points, C a cluster of lights, x and y are their representatives, S(G) is the sum of the strengths of the points |
//! | gather points | the vertices of `--gather` camera paths through the pixel: over the pixel's filter, the lens, mirrors, glass and media. Strength: filter weight x throughput / number of paths |
//! | product graph | its nodes are the pairs of a node of the gather tree and a node of a light tree; it is never stored |
//! | refinement | start with the pairs of the roots; split the pair with the largest error bound on its larger side, until that bound is below `--error` times the estimate of L(pixel) |
//! | in media | gather points receive light from lights on light sources; paths find the other light there |
//! | left out | the paper's instants of time (no scene here moves) |
//!
//! Read next: `pairs.rs` (split, representatives, estimate), `tree.rs` (the gather tree and its bounds), `gather.rs`.

mod cube;
mod gather;
mod pairs;
mod tree;

#[cfg(test)]
mod tests;

use gi_core::eye::{EyeEvent, EyeMediumVertex, EyeVertex, EyeWalk};
use gi_core::film::{Film, Sample as PixelSample};
use gi_core::filter::FilterPlaces;
use gi_core::math::Rgb;
use gi_core::rng::hash_words;
use vpl::MIN_ROUGHNESS;

use crate::Lightcuts;
use crate::cut::{Cut, Limits, Lit};
use crate::light::Lights;
use crate::tree::NodeId;
use crate::view::PathState;
use gather::{Gather, GatherPoint, Place};
use pairs::{Pair, Product};
use tree::GatherTree;

/// Choose the cut of a pixel: refine the cut of all pairs of roots.
fn choose(product: &Product, limits: &Limits, cut: &mut Cut<Pair>) {
    for (g, gather_tree) in product.trees.iter().enumerate() {
        let at = &product.gathers[gather_tree.members(0)[0] as usize].at;
        for (l, light_tree) in product.lights.forest.trees.iter().enumerate() {
            if at.counts(light_tree) {
                let root = |tree: usize| NodeId { tree: tree as u32, node: 0 };
                product.add(cut, root(g), root(l));
            }
        }
    }
    let max_pairs = limits.max_clusters() as usize;
    while !cut.is_good(limits) && cut.clusters.len() < max_pairs {
        let Some(worst) = cut.heap.pop() else { return };
        // The low bits of an entry are the index of the pair.
        product.split(cut, worst as u32);
    }
}

/// The light that all lights bring to all gather points of a pixel.
fn light_by_product_cut<'a>(
    lights: &Lights<'_, 'a>,
    gathers: &[Gather<'_, 'a>],
    limits: &Limits,
    c: f32,
    seed: u32,
) -> Lit {
    let trees = GatherTree::build_all(gathers, c);
    let product = Product { lights, gathers, trees: &trees, c, seed };
    let mut cut = Cut::default();
    choose(&product, limits, &mut cut);
    product.add_up(&mut cut, limits)
}

/// The camera paths of a pixel.
struct Paths<'a> {
    /// Their vertices that lights illuminate.
    points: Vec<GatherPoint<'a>>,
    /// Sum of the filter's weights, over the number of paths.
    weight: f32,
    /// Everything else that the paths have found, multiplied by the same weights.
    sample: PixelSample,
}

impl<'a> Lightcuts<'a> {
    /// Illuminate the gather points of each pixel by a cut of pairs.
    pub(crate) fn add_pass_by_pairs(&self, lights: &Lights<'_, 'a>, index: u32, film: &mut Film) {
        let places = FilterPlaces::new(film.filter().filter());
        film.add_filtered_pass(|pixel| {
            let Paths { points, weight, mut sample } = self.paths(&places, pixel, index);
            let lit = self.light_pixel(lights, &points, pixel, index);
            if !points.is_empty() {
                self.tally.note(&lit, true);
                self.tally.gathered(points.len() as u32);
            }
            sample.radiance.direct += lit.direct;
            sample.radiance.indirect += lit.indirect;
            (weight, sample)
        });
    }

    /// The light and the cut size of a pixel, for `--show cut-size`.
    pub(crate) fn cut_of_pixel(
        &self,
        lights: &Lights<'_, 'a>,
        places: &FilterPlaces,
        pixel: [usize; 2],
    ) -> Lit {
        let index = self.lights.pass;
        let paths = self.paths(places, pixel, index);
        self.light_pixel(lights, &paths.points, pixel, index)
    }

    /// The light that the virtual lights bring to gather points.
    fn light_pixel(
        &self,
        lights: &Lights<'_, 'a>,
        points: &[GatherPoint<'a>],
        [x, y]: [usize; 2],
        index: u32,
    ) -> Lit {
        let gathers = Gather::prepare(&self.view(), points);
        // As in the light trees, directions count like positions times the radius of the scene.
        let c = self.setting.scene.radius();
        let seed = hash_words(&[self.setting.seed, index, x as u32, y as u32]);
        light_by_product_cut(lights, &gathers, &self.params.cut, c, seed)
    }

    /// Follow the camera paths of a pixel.
    fn paths(&self, places: &FilterPlaces, pixel: [usize; 2], index: u32) -> Paths<'a> {
        let (count, size) = (self.params.gather, self.setting.camera.size());
        let mut paths = Paths { points: Vec::new(), weight: 0.0, sample: PixelSample::default() };
        for k in 0..count {
            let number = index.wrapping_mul(count).wrapping_add(k);
            let mut weight = 1.0 / count as f32;
            let place = |u| {
                let (at, w) = places.sample_2d(u, pixel, size);
                weight *= w;
                at
            };
            let limits = self.params.limits;
            let mut walk = EyeWalk::through_pixel_at(&self.setting, limits, pixel, number, place);
            self.use_media(&mut walk);
            while let Some(event) = &walk.next_event() {
                let points = &mut paths.points;
                let goes_on = match event {
                    EyeEvent::Surface(v) => {
                        walk.add_emitted(v);
                        if v.wants_estimate() {
                            self.add_point(v, &mut walk, weight, points);
                        }
                        walk.add_direct(v);
                        walk.scatter(v)
                    }
                    EyeEvent::Medium(v) => self.add_point_within(v, &mut walk, weight, points),
                };
                if !goes_on {
                    break;
                }
            }
            paths.add(&walk.sample(), weight, count);
        }
        paths
    }

    /// Keep a vertex as a gather point. The path continues for the light that the lights do not bring to it.
    fn add_point(
        &self,
        v: &EyeVertex<'a>,
        walk: &mut EyeWalk<'a>,
        weight: f32,
        points: &mut Vec<GatherPoint<'a>>,
    ) {
        let Some(bsdf) = v.bsdf.broad(v.wo, MIN_ROUGHNESS) else { return };
        let path = PathState { segments: v.segments, non_delta: v.non_delta, medium: v.medium };
        if self.view().deepest(path).is_none() {
            return;
        }
        let Some(estimate) = self.estimate(v, &bsdf, Rgb::BLACK, Rgb::BLACK) else { return };
        walk.add_estimate(v, estimate);
        points.push(GatherPoint {
            place: Place::Surface(v.surface, bsdf),
            wo: v.wo,
            path,
            strength: v.throughput * weight.abs(),
            negative: weight < 0.0,
        });
    }

    /// Keep a point of a medium as a gather point for the lights on light sources. The path continues for all other light. Returns
    /// whether it continues.
    fn add_point_within(
        &self,
        v: &EyeMediumVertex,
        walk: &mut EyeWalk<'a>,
        weight: f32,
        points: &mut Vec<GatherPoint<'a>>,
    ) -> bool {
        let path = PathState::of(walk, Some(v.medium));
        if !self.view().is_lit_in_medium(path) {
            walk.add_direct_within(v);
            return walk.scatter_within(v);
        }
        points.push(GatherPoint {
            place: Place::Medium(v.p, v.medium),
            wo: v.wo,
            path,
            strength: walk.throughput_within(v) * weight.abs(),
            negative: weight < 0.0,
        });
        walk.scatter_within_after_estimate(v)
    }
}

impl Paths<'_> {
    /// Add what a path has found, apart from the light at its gather points.
    fn add(&mut self, sample: &PixelSample, weight: f32, count: u32) {
        let sum = &mut self.sample;
        self.weight += weight;
        sum.radiance.add(&sample.radiance, weight);
        let share = 1.0 / count as f32;
        sum.albedo += sample.albedo * share;
        sum.normal += sample.normal * share;
        sum.depth += sample.depth * share;
    }
}

//! Aims light that is scattered far away toward the region that matters.

use super::{
    EMISSION_DIMENSIONS, LightVertex, LightWalk, Roulette, SCATTER_DIMENSIONS, VERTEX_DIMENSIONS,
};
use crate::bsdf::Scatter;
use crate::light::Targets;
use crate::math::Rgb;
use crate::warp;

/// Fraction of the paths that are aimed at the goal, if there is one.
const GUIDED: f32 = 0.5;

impl<'a> LightWalk<'a> {
    /// Like [`LightWalk::scatter`], but half of the paths that scatter far from the goal of [`Targets`] are aimed at
    /// it. Every path can still be sampled. Roulette does not end aimed paths, because their powers are already small.
    pub fn scatter_toward(
        &mut self,
        vertex: &LightVertex<'a>,
        roulette: Roulette,
        targets: &Targets,
    ) -> bool {
        let Some((axis, one_minus_cos)) = targets.goal_from(vertex.surface.p) else {
            return self.scatter(vertex, roulette);
        };
        if vertex.bsdf.is_delta() {
            return self.scatter(vertex, roulette);
        }
        self.sampler
            .jump_to(EMISSION_DIMENSIONS + (self.met + 1) * VERTEX_DIMENSIONS - SCATTER_DIMENSIONS);
        self.met += 1;
        let ([u_choice, u_roulette], u) = (self.sampler.next_2d(), self.sampler.next_2d());
        let wi = if u_choice < GUIDED {
            axis.to_world(warp::cone(u, one_minus_cos))
        } else {
            let u_choice = (u_choice - GUIDED) / (1.0 - GUIDED);
            let Some(s) = vertex.bsdf.sample(vertex.wo, u_choice, u) else { return false };
            if s.delta || s.null {
                let s = Scatter { weight: s.weight / (1.0 - GUIDED), ..s };
                return self.leave(vertex, &s, roulette, u_roulette);
            }
            s.wi
        };
        let (f_cos, pdf_bsdf) = vertex.bsdf.f_cos_pdf(vertex.wo, wi);
        // Compute 1 - cos as half the squared distance of unit vectors, which is accurate for a narrow cone.
        let aimed = 0.5 * wi.distance_squared(axis.n) <= one_minus_cos;
        let pdf_goal = if aimed { warp::cone_pdf(one_minus_cos) } else { 0.0 };
        let pdf_w = GUIDED * pdf_goal + (1.0 - GUIDED) * pdf_bsdf;
        let weight = if pdf_w > 0.0 { f_cos / pdf_w } else { Rgb::BLACK };
        let s = Scatter { wi, weight, pdf_w, delta: false, null: false, eta: 1.0 };
        self.leave(vertex, &s, if aimed { Roulette::Off } else { roulette }, u_roulette)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, Mesh, Shape};
    use crate::light::LightSource;
    use crate::material::Material;
    use crate::sampler::Sampler;
    use crate::scene::{Scene, SceneParts};
    use crate::texture::Texture;
    use gi_stats::{Running, welch_t_test};
    use glam::Vec3;

    /// A patch ten metres from the origin, diffuse (0) or plastic (1), under a sun.
    fn patch(material: usize) -> Scene {
        let at = |x, z| Vec3::new(x, 0.0, z);
        let positions = vec![at(9.0, -1.0), at(9.0, 1.0), at(11.0, 1.0), at(11.0, -1.0)];
        let mesh =
            Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]].into(), ..Mesh::default() };
        let materials = vec![
            Material::Diffuse { reflectance: Texture::grey(0.5) },
            Material::Plastic {
                eta: 1.5,
                diffuse: Texture::grey(0.5),
                specular: Texture::grey(1.0),
                nonlinear: false,
                roughness: None,
            },
        ];
        let sun = LightSource::Directional { direction: -Vec3::Y, irradiance: Rgb::WHITE };
        let parts = SceneParts {
            shapes: vec![Shape::new("patch", Geometry::Mesh(mesh), material)],
            materials,
            lights: vec![sun],
            ..SceneParts::default()
        };
        Scene::new(parts).expect("a scene")
    }

    #[test]
    fn aimed_scattering_has_the_power_and_the_directions_of_usual_scattering() {
        for material in 0..2 {
            let scene = patch(material);
            // Light falls on the patch, and should end near a point ten metres away.
            let ends = [0.0, 0.5, 1.0].map(|x| (Vec3::new(x, 1.0, 0.0), 1.0)).to_vec();
            let targets =
                scene.around([vec![(Vec3::X * 10.0, 1.0)], ends]).expect("a light at infinity");
            // The total power, and the power by direction: out, up, and to the goal, where aimed paths are frequent.
            let mut sums = [[Running::default(); 4]; 2];
            for (aimed, sums) in sums.iter_mut().enumerate() {
                for path in 0..60_000 {
                    let sampler = Sampler::new(3, aimed as u32, path);
                    let walk = LightWalk::begin_toward(&scene, sampler, &targets);
                    let mut walk = walk.expect("it shines");
                    let mut values = [0.0; 4];
                    if let Some(vertex) = walk.next_vertex() {
                        let goes_on = match aimed {
                            0 => walk.scatter(&vertex, Roulette::Off),
                            _ => walk.scatter_toward(&vertex, Roulette::Off, &targets),
                        };
                        let (power, d) = (walk.power.g, walk.ray.d);
                        let (axis, one_minus_cos) =
                            targets.goal_from(vertex.surface.p).expect("far away");
                        let inside = 0.5 * d.distance_squared(axis.n) <= one_minus_cos;
                        if goes_on {
                            values =
                                [1.0, d.x, d.y, f32::from(u8::from(inside))].map(|g| g * power);
                        }
                    }
                    sums.iter_mut().zip(values).for_each(|(s, v)| s.push(f64::from(v)));
                }
            }
            for (k, (blind, aimed)) in sums[0].iter().zip(&sums[1]).enumerate() {
                let p = welch_t_test(blind, aimed);
                let (blind, aimed) = (blind.mean(), aimed.mean());
                assert!(p > 1e-3, "material {material}, moment {k}: {blind}, {aimed}, p = {p:.1e}");
            }
            let share = sums.map(|s| s[3].variance_of_mean());
            assert!(share[1] < 0.2 * share[0], "the goal's light has less noise: {share:?}");
        }
    }
}

use glam::{Affine3A, Vec2, Vec3};

use crate::math::Rgb;
use crate::texture::{Bitmap, Texture};

/// The directions that the picture of a [`LightSource::Projector`] covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Window {
    /// The cone. The unit square of the picture circumscribes it.
    Cone,
    /// A rectangle at distance one on the axis, given by half its width and height. The picture's u is along -x and its
    /// v along -y, as for a camera. The picture is the irradiance of the rectangle, and the light's intensity is that
    /// toward the corners. `cutoff` and `beam` include the corners.
    Irradiance(Vec2),
    /// The same rectangle, but the picture is the intensity.
    Intensity(Vec2),
    /// All directions: the picture is the square of [`crate::warp::unfolded_sphere`], with the axis at its centre.
    Unfolded,
    /// All directions, by longitude and latitude: u = atan2(y, x) / 2 pi and v = acos(z) / pi.
    Latitudes,
}

/// A light of the scene that is not a surface. ([`crate::geometry::Shape::emission`] makes surfaces emit.)
#[derive(Clone, Debug)]
pub enum LightSource {
    /// The same intensity in all directions.
    Point {
        /// World position.
        position: Vec3,
        /// Power per steradian.
        intensity: Rgb,
    },
    /// A cone that fades linearly in the angle between beam width and cutoff.
    Spot {
        /// World position.
        position: Vec3,
        /// Unit axis.
        direction: Vec3,
        /// Power per steradian inside the beam.
        intensity: Rgb,
        /// Half angle of the cone, radians.
        cutoff: f32,
        /// Half angle within which the intensity is full, radians.
        beam: f32,
    },
    /// A point whose intensity is a picture: a spot with a picture in front of it, a projector, or a goniometric light.
    Projector {
        /// World position.
        position: Vec3,
        /// Axes of the picture's u and v, and the axis of the cone. Only their directions count, but for pictures of all
        /// directions their lengths count too.
        axes: [Vec3; 3],
        /// Power per steradian inside the beam where the picture is one.
        intensity: Rgb,
        /// Half angle of the cone, radians.
        cutoff: f32,
        /// Half angle within which the intensity is full, radians.
        beam: f32,
        /// The picture, with values up to one.
        picture: Texture,
        /// The directions that it covers.
        window: Window,
    },
    /// Parallel light from far away.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// Irradiance on a plane perpendicular to it.
        irradiance: Rgb,
    },
    /// The same radiance from all directions.
    Constant {
        /// Radiance.
        radiance: Rgb,
    },
    /// A latitude-longitude picture at infinity, local +y up.
    Environment {
        /// Radiance; `u = atan2(x, -z) / 2 pi`, `v = acos(y) / pi` of the local direction.
        image: Bitmap,
        /// Factor on the picture.
        scale: f32,
        /// Rotation from local to world.
        to_world: Affine3A,
    },
    /// A disc of constant radiance at infinity, such as the sun.
    DistantDisc {
        /// Unit direction toward the centre of the disc.
        direction: Vec3,
        /// Angular radius, radians.
        angular_radius: f32,
        /// Radiance.
        radiance: Rgb,
    },
}

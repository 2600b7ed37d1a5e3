//! The one test binary of what crosses crates.

/// Techniques against each other and against the reference.
mod agreement;
/// Scenes with known answers, for every technique that can render them.
mod analytic;
/// The same bits for any number of threads.
mod determinism;
/// What the dipole of translucent solids is held to.
mod dipole;
/// Values at the end of a range.
mod ends_of_ranges;
/// What instant radiosity is held to.
mod instant_radiosity_facts;
/// What irradiance caching is held to.
mod irrcache_facts;
/// What lightcuts are held to.
mod lightcuts_facts;
/// All programs against each other on scenes that combine surfaces, maps, media, lights and places.
mod matrix;
/// What light in participating media is held to.
mod media;
/// Paths from the lights in participating media.
mod media_light;
/// What the programs' options say of themselves.
mod options;
/// Photon mapping.
mod photonmap;
/// What progressive photon mapping is held to.
mod ppm_facts;
/// What radiance caching is held to.
mod radcache_facts;
/// Scenes put together at random.
mod random_scenes;
/// Small lamps near surfaces and behind glass.
mod small_lamps;
/// Walls without thickness.
mod thin_walls;

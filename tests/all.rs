//! The test binary for everything that involves several crates.

/// Compares techniques with each other and with the reference.
mod agreement;
/// Scenes with known answers, for every technique that can render them.
mod analytic;
/// Pictures are the same, bit for bit, for any number of threads.
mod determinism;
/// Checks the dipole of translucent solids.
mod dipole;
/// Documents: their links, and the files that they name.
mod documents;
/// Values at the end of a range.
mod ends_of_ranges;
/// Checks instant radiosity.
mod instant_radiosity_facts;
/// Checks irradiance caching.
mod irrcache_facts;
/// Checks lightcuts.
mod lightcuts_facts;
/// Lightcuts in participating media.
mod lightcuts_media;
/// Many lamps: the light tree.
mod many_lamps;
/// Compares all programs on scenes that combine surfaces, maps, media, lights and places.
mod matrix;
/// Checks light in participating media.
mod media;
/// Paths from the lights in participating media.
mod media_light;
mod media_varying;
/// Checks the help of the programs' options.
mod options;
/// Renders scenes in pbrt's format.
mod pbrt_scenes;
/// Checks photon mapping.
mod photonmap;
/// Irradiance at points.
mod points;
/// Checks progressive photon mapping.
mod ppm_facts;
/// Checks radiance caching.
mod radcache_facts;
/// Compares paths from both ends on random scenes.
mod random_scenes;
/// Photon maps against references of scenes whose light is mostly caustic.
mod references;
/// Neighbouring pixels that use each other's paths.
mod reuse;
/// Small lamps near surfaces and behind glass.
mod small_lamps;
/// Extra camera rays that look only for light sources.
mod source_rays;
/// Walls without thickness.
mod thin_walls;

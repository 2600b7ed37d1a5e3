//! Both caches, and how they are created.

use gi_core::technique::Setting;
use lightcache::control::{Control, ErrorControl};
use lightcache::record::Record;
use lightcache::{Cache, Weighing};

use crate::params::Params;
use crate::record::RadianceRecord;

/// Both caches.
pub struct Caches {
    /// Irradiance records, for surfaces without a rough glossy lobe.
    pub diffuse: Cache<Record>,
    /// Records of radiance and irradiance, for surfaces with such a lobe.
    pub glossy: Cache<RadianceRecord>,
}

impl Caches {
    /// Empty caches for a scene.
    pub(crate) fn empty(setting: &Setting, params: &Params) -> Self {
        let bounds = setting.scene.bounds();
        let how = |error: ErrorControl, accuracy: f32| {
            let control = Control { error, radius: params.radius, accuracy };
            let clamped = params.reach.neighbour_clamping && control.has_limits();
            let slope = clamped.then(|| control.slope());
            Weighing { accuracy, weights: params.weights, slope }
        };
        Caches {
            diffuse: Cache::new(bounds, how(params.error, params.accuracy)),
            glossy: Cache::new(bounds, how(params.glossy_error, params.glossy_accuracy)),
        }
    }

    /// The irradiance of the records of both caches.
    pub fn irradiance_records(&self) -> impl Iterator<Item = &Record> {
        let glossy = self.glossy.records().iter().map(|r| &r.irradiance);
        self.diffuse.records().iter().chain(glossy)
    }

    /// Number of records in both caches.
    pub fn count(&self) -> usize {
        self.diffuse.records().len() + self.glossy.records().len()
    }
}

//! The numbers that are printed and stored with the picture.

use gi_core::bytes::{Reader, Writer};
use gi_core::caustics::FocusedLight;
use vpl::{Energy, Pilot, Vpls};

/// Sums over all passes.
#[derive(Default)]
pub(crate) struct Totals {
    /// Light from all connections, and light that the clamp cut off.
    pub(crate) energy: Energy,
    lights: u64,
    paths: u64,
}

impl Totals {
    /// Count the lights of a pass.
    pub(crate) fn add(&mut self, vpls: &Vpls) {
        self.lights += vpls.lights.len() as u64;
        self.paths += vpls.paths;
    }

    /// The sums for a resumed run.
    pub(crate) fn save(&self) -> Vec<u8> {
        let mut w = Writer::default();
        self.energy.parts().into_iter().for_each(|n| w.u64(n));
        w.u64(self.lights);
        w.u64(self.paths);
        w.into_bytes()
    }

    /// Add stored sums.
    pub(crate) fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let mut r = Reader::new(state);
        self.energy.add([r.u64()?, r.u64()?, r.u64()?]);
        self.lights += r.u64()?;
        self.paths += r.u64()?;
        r.end()
    }

    pub(crate) fn statistics(
        &self,
        pilot: &Pilot,
        focused: &FocusedLight,
        vpls: &Vpls,
    ) -> Vec<(String, f64)> {
        let [kept, cut] = self.energy.kept_and_cut();
        vec![
            ("vpls".into(), self.lights as f64),
            ("light_paths".into(), self.paths as f64),
            ("reflectance".into(), pilot.reflectance.into()),
            ("connections".into(), self.energy.connections() as f64),
            ("energy_cut".into(), cut / (kept + cut).max(f64::MIN_POSITIVE)),
            ("caustic_photons".into(), focused.photons() as f64),
            ("caustic_radius".into(), focused.mean_radius()),
            ("vpl_bytes".into(), vpls.memory_bytes() as f64),
        ]
    }
}

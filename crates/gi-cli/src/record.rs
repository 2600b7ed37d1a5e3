//! What a run says about itself: the metadata of its picture, and its statistics.

use std::time::Duration;

use gi_core::film::Film;
use gi_core::image_io::Layers;
use gi_core::technique::{Picture, Technique};
use serde_json::{Map, Value, json};

use crate::stop::Signal;
use crate::{Budget, Common, identity};

/// Version of the statistics' layout: the number grows when a name changes its meaning or goes away.
const SCHEMA: u32 = 1;

/// What is known before the first pass.
pub(crate) struct About<'a> {
    pub(crate) program: &'a str,
    pub(crate) arguments: &'a [String],
    pub(crate) common: &'a Common,
    pub(crate) size: [usize; 2],
    pub(crate) scene_hash: u64,
    pub(crate) warnings: Vec<String>,
    /// When the run began.
    pub(crate) date: String,
    /// Time to read the scene, to build its tree, and to prepare.
    pub(crate) load: Duration,
    pub(crate) build: Duration,
    pub(crate) prepare: Duration,
}

/// What is known after some passes.
#[derive(Clone, Default)]
pub(crate) struct SoFar {
    pub(crate) passes: u32,
    /// How many of them other runs have made.
    pub(crate) earlier: u32,
    /// Time of the passes, and of what was written between them.
    pub(crate) render: Duration,
    /// The signal that ended the run before its time.
    pub(crate) stopped: Option<Signal>,
    pub(crate) reach: String,
    pub(crate) technique: Vec<(String, f64)>,
}

impl About<'_> {
    /// What is known now. `elapsed` is the time since preparation began.
    pub(crate) fn so_far<'t, T: Technique<'t>>(
        &self,
        technique: &T,
        film: &Film,
        elapsed: Duration,
        stopped: Option<Signal>,
    ) -> SoFar {
        SoFar {
            passes: film.passes(),
            earlier: 0,
            render: elapsed.saturating_sub(self.prepare),
            stopped,
            reach: technique.reach(),
            technique: technique.statistics(),
        }
    }

    /// What an EXR says about how it came to be.
    pub(crate) fn metadata(&self, so_far: &SoFar) -> Vec<(String, String)> {
        let seconds = (self.prepare + so_far.render).as_secs_f64();
        let mut all = vec![
            ("gi.program", self.program.to_string()),
            ("gi.version", identity::NUMBER.to_string()),
            ("gi.command", self.arguments.join(" ")),
            ("gi.passes", so_far.passes.to_string()),
            ("gi.seed", self.common.seed.to_string()),
            ("gi.seconds", format!("{seconds:.3}")),
            ("gi.scene", self.common.scene.display().to_string()),
            ("gi.scene_hash", format!("{:016x}", self.scene_hash)),
            ("gi.reach", so_far.reach.clone()),
            ("gi.date", self.date.clone()),
            ("gi.processor", identity::processor()),
            ("gi.instruction_set", gi_core::instruction_set().to_string()),
            ("gi.threads", rayon::current_num_threads().to_string()),
        ];
        if !identity::COMMIT.is_empty() {
            all.push(("gi.commit", identity::COMMIT.to_string()));
        }
        if let Some(signal) = so_far.stopped {
            all.push(("gi.stopped", self.stopped(signal, so_far.passes)));
        }
        all.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
    }

    /// How the run was stopped.
    fn stopped(&self, signal: Signal, passes: u32) -> String {
        let of = match self.common.budget() {
            Budget::Passes(n) => format!(" of {n}"),
            Budget::Time(_) => String::new(),
        };
        format!("by {} after {passes}{of} passes", signal.name())
    }

    /// The statistics, with the mean of the picture and the time to save it.
    pub(crate) fn statistics(&self, so_far: &SoFar, mean: [f64; 3], save: Duration) -> Value {
        let seconds = |time: Duration| time.as_secs_f64();
        let [w, h] = self.size;
        let samples = (w * h) as f64 * f64::from(so_far.passes - so_far.earlier);
        let technique: Map<String, Value> =
            so_far.technique.iter().map(|(k, v)| (k.clone(), json!(v))).collect();
        json!({
            "schema": SCHEMA,
            "program": self.program,
            "version": identity::NUMBER,
            "commit": Some(identity::COMMIT).filter(|commit| !commit.is_empty()),
            "command": self.arguments,
            "date": self.date,
            "processor": identity::processor(),
            "instruction_set": gi_core::instruction_set(),
            "threads": rayon::current_num_threads(),
            "scene": self.common.scene.display().to_string(),
            "scene_hash": format!("{:016x}", self.scene_hash),
            "size": self.size,
            "passes": so_far.passes,
            "seed": self.common.seed,
            "stopped": so_far.stopped.map(|signal| self.stopped(signal, so_far.passes)),
            "seconds": {
                "load": seconds(self.load),
                "build": seconds(self.build),
                "prepare": seconds(self.prepare),
                "render": seconds(so_far.render),
                "save": seconds(save),
            },
            "samples_per_second": samples / seconds(self.prepare + so_far.render),
            "mean_radiance": mean,
            "reach": so_far.reach,
            "technique": technique,
            "warnings": self.warnings,
        })
    }
}

/// The mean of the shown radiance.
pub(crate) fn mean(film: &Film) -> [f64; 3] {
    let radiance = film.radiance();
    radiance.iter().fold([0f64; 3], |sum, c| {
        let c = c.to_array();
        std::array::from_fn(|k| sum[k] + f64::from(c[k]) / radiance.len() as f64)
    })
}

/// Add a technique's picture as layers: `Name.channel`.
pub(crate) fn add_layers(layers: &mut Layers, picture: &Picture) {
    let mut name: Vec<char> = picture.name.chars().collect();
    name[0] = name[0].to_ascii_uppercase();
    let name: String = name.into_iter().collect();
    let mut push = |channel: &str, values: Vec<f32>| {
        layers.channels.push((format!("{name}.{channel}"), values));
    };
    if picture.channels.is_empty() {
        for (k, channel) in ["R", "G", "B"].into_iter().enumerate() {
            push(channel, picture.view.iter().map(|c| c.to_array()[k]).collect());
        }
    }
    picture.channels.iter().for_each(|(channel, values)| push(channel, values.clone()));
}

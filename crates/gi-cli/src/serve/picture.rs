//! The picture at some pass, as the page downloads it: layers of half floats.

use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use gi_core::image_io::Layers;
use serde_json::{Value, json};

use crate::record::SoFar;

/// The name that the channels R, G and B have together on the page.
const RADIANCE: &str = "Picture";

/// The picture after some passes.
pub(super) struct Snapshot {
    /// Number of the snapshot: 1, 2, ...
    version: u32,
    passes: u32,
    /// The technique's statistics.
    technique: Vec<(String, f64)>,
    /// Root mean square of the standard error of all channels, relative to their mean.
    noise: Option<f64>,
    layers: Vec<Layer>,
}

/// Some channels that belong together.
struct Layer {
    name: String,
    /// The channels' names within the layer, and their values in row order.
    channels: Vec<(String, Vec<f32>)>,
    /// The same as half floats, once somebody has asked for them.
    encoded: OnceLock<Encoded>,
}

/// A layer for the page.
#[derive(Clone)]
pub(super) struct Encoded {
    /// What a half float is multiplied by.
    pub(super) scale: f64,
    /// The snapshot that it belongs to.
    pub(super) version: u32,
    /// Half floats, little-endian, channel by channel.
    pub(super) bytes: Arc<[u8]>,
}

impl Snapshot {
    pub(super) fn new(version: u32, layers: Layers, so_far: &SoFar) -> Self {
        let noise = noise(&layers);
        let mut all: Vec<Layer> = Vec::new();
        for (name, values) in layers.channels {
            let (name, channel) = match name.rsplit_once('.') {
                Some((layer, channel)) => (layer.to_string(), channel.to_string()),
                None if ["R", "G", "B"].contains(&name.as_str()) => (RADIANCE.into(), name),
                None => (name.clone(), name),
            };
            match all.iter_mut().find(|layer| layer.name == name) {
                Some(layer) => layer.channels.push((channel, values)),
                None => {
                    let channels = vec![(channel, values)];
                    all.push(Layer { name, channels, encoded: OnceLock::new() });
                }
            }
        }
        let technique = so_far.technique.clone();
        Snapshot { version, passes: so_far.passes, technique, noise, layers: all }
    }

    /// A layer by name, and the time that it took to encode it.
    pub(super) fn layer(&self, name: &str) -> Option<(Encoded, Duration)> {
        let layer = self.layers.iter().find(|layer| layer.name == name)?;
        let clock = Instant::now();
        let encoded = layer.encoded.get_or_init(|| {
            let halves = gi_page::halves(layer.channels.iter().flat_map(|(_, values)| values));
            let bytes = halves.bits.iter().flat_map(|bits| bits.to_le_bytes()).collect();
            Encoded { scale: halves.scale, version: self.version, bytes }
        });
        Some((encoded.clone(), clock.elapsed()))
    }

    /// What the page is told about it.
    pub(super) fn describe(&self) -> Value {
        let layer = |layer: &Layer| {
            let channels: Vec<&str> = layer.channels.iter().map(|(name, _)| &name[..]).collect();
            json!({ "name": layer.name, "channels": channels, "version": self.version })
        };
        let technique: Vec<Value> =
            self.technique.iter().map(|(name, value)| json!([name, value])).collect();
        let error = self.technique.iter().find(|(name, _)| name == "error_estimate");
        json!({
            "passes": self.passes,
            "error": error.map(|(_, value)| value),
            "noise": self.noise,
            "technique": technique,
            "layers": self.layers.iter().map(layer).collect::<Vec<Value>>(),
        })
    }
}

/// Root mean square of the standard error of all channels, relative to their mean. None if it is unknown: after one pass, or where
/// there are pixels that are not finite.
fn noise(layers: &Layers) -> Option<f64> {
    let sum = |names: [&str; 3]| -> Option<f64> {
        names.iter().try_fold(0.0, |sum, name| {
            Some(sum + layers.channel(name)?.iter().map(|v| f64::from(*v)).sum::<f64>())
        })
    };
    let count = (3 * layers.width * layers.height) as f64;
    let mean = sum(["R", "G", "B"])? / count;
    let variance = sum(["Variance.R", "Variance.G", "Variance.B"])? / count;
    Some(variance.sqrt() / mean).filter(|noise| noise.is_finite() && variance > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot(channels: &[(&str, [f32; 2])]) -> Snapshot {
        let channels = channels.iter().map(|(n, v)| (n.to_string(), v.to_vec())).collect();
        let layers = Layers { width: 2, height: 1, channels, ..Layers::default() };
        let so_far = SoFar {
            earlier: 0,
            passes: 3,
            render: Duration::ZERO,
            stopped: None,
            reach: String::new(),
            technique: vec![("records".into(), 7.0), ("error_estimate".into(), 0.5)],
        };
        Snapshot::new(4, layers, &so_far)
    }

    #[test]
    fn channels_are_grouped_by_layer_in_their_order() {
        let of = |k: f32| [k, -k];
        let all =
            [("R", of(1.0)), ("N.X", of(2.0)), ("G", of(3.0)), ("Z", of(4.0)), ("N.Y", of(5.0))];
        let snapshot = snapshot(&all);
        let described = snapshot.describe();
        let layer = |name: &str, channels: &[&str]| json!({ "name": name, "channels": channels, "version": 4 });
        let layers = [layer("Picture", &["R", "G"]), layer("N", &["X", "Y"]), layer("Z", &["Z"])];
        assert_eq!(described["layers"], json!(layers));
        assert_eq!(described["technique"], json!([["records", 7.0], ["error_estimate", 0.5]]));
        assert_eq!((&described["passes"], &described["error"]), (&json!(3), &json!(0.5)));
        let (encoded, _) = snapshot.layer("N").expect("a layer");
        let expected = gi_page::halves([2.0f32, -2.0, 5.0, -5.0].iter());
        let bytes: Vec<u8> = expected.bits.iter().flat_map(|b| b.to_le_bytes()).collect();
        assert_eq!(
            (encoded.scale, encoded.version, &*encoded.bytes),
            (expected.scale, 4, &bytes[..])
        );
        assert!(snapshot.layer("n").is_none());
    }

    #[test]
    fn noise_is_the_standard_error_relative_to_the_mean() {
        let rgb = |names: [&'static str; 3], v| names.map(|name| (name, v));
        let mean = rgb(["R", "G", "B"], [1.0, 3.0]);
        let noise = |variance| {
            let variance = rgb(["Variance.R", "Variance.G", "Variance.B"], variance);
            snapshot(&[mean, variance].concat()).noise
        };
        assert_eq!(noise([0.0, 0.5]), Some(0.25));
        assert_eq!(noise([0.0, 0.0]), None);
        assert_eq!(noise([0.0, f32::NAN]), None);
        assert_eq!(snapshot(&mean).noise, None);
    }
}

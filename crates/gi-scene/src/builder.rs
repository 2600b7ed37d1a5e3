//! The state of a scene that is being built.

use gi_core::medium::MediumId;
use std::collections::{HashMap, HashSet};

use gi_core::scene::SceneParts;

use crate::assets::Assets;
use crate::attributes::AttributeSource;
use crate::diagnostics::Report;
use crate::document::ObjectId;
use crate::origins::Origins;

/// A scene that is being built. Each kind of plugin adds methods to it in its own file.
pub(crate) struct Builder<'a> {
    pub(crate) report: &'a Report,
    pub(crate) assets: Assets,
    pub(crate) parts: SceneParts,
    pub(crate) origins: Origins,
    /// For each material, whether light can pass through it.
    pub(crate) transmits: Vec<bool>,
    pub(crate) material_of: HashMap<ObjectId, usize>,
    /// BSDFs under construction, outermost first.
    pub(crate) open_materials: Vec<ObjectId>,
    pub(crate) black: Option<usize>,
    pub(crate) grey: Option<usize>,
    pub(crate) null: Option<usize>,
    pub(crate) medium_of: HashMap<ObjectId, MediumId>,
    pub(crate) group_of: HashMap<ObjectId, usize>,
    pub(crate) built_shapes: HashSet<ObjectId>,
    /// Emitters that belong to shapes.
    pub(crate) used_emitters: HashSet<ObjectId>,
    /// The mesh attributes of the shape that is being built, if its textures read them. Such a shape shares no materials.
    pub(crate) attributes: Option<AttributeSource>,
}

impl<'a> Builder<'a> {
    /// An empty builder.
    pub(crate) fn new(report: &'a Report, assets: Assets) -> Self {
        Builder {
            report,
            assets,
            parts: SceneParts::default(),
            origins: Origins::default(),
            transmits: Vec::new(),
            material_of: HashMap::new(),
            open_materials: Vec::new(),
            black: None,
            grey: None,
            null: None,
            medium_of: HashMap::new(),
            group_of: HashMap::new(),
            built_shapes: HashSet::new(),
            used_emitters: HashSet::new(),
            attributes: None,
        }
    }
}

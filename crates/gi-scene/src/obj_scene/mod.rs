//! Loads a bare OBJ file with its materials as a whole scene.

mod mtl;
mod pictures;
mod surfaces;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

use gi_core::filter::Filter;
use gi_core::geometry::{Geometry, Shape};
use gi_core::guard::guarded;
use gi_core::math::Bounds;
use gi_core::scene::SceneParts;
use glam::DVec3;

use crate::diagnostics::Report;
use crate::files::{self, Folders};
use crate::framing;
use crate::hash::Hash;
use crate::local::Extent;
use crate::options::{Loaded, Options};
use crate::origins::{Origins, ShapeOrigin};
use crate::precision;
use crate::shapes::{mesh_file, obj, smooth};
use crate::statements::{latin_1, name_before_comment};
use mtl::Entry;
use pictures::Pictures;

/// Read a bare OBJ file.
pub(crate) fn load(path: &Path, options: &Options, report: &Report) -> Option<Loaded> {
    let mut reader = Reader {
        report,
        folder: files::folder_of(path),
        hash: Hash::default(),
        parts: SceneParts::default(),
        origins: Origins::default(),
        pictures: Pictures::default(),
        folders: Folders::default(),
    };
    warn_of_unused(options, report);
    let contents = match reader.read(path) {
        Ok(contents) => contents,
        Err(why) => {
            report.error_nowhere(format!("cannot read `{}`: {why}", path.display()));
            return None;
        }
    };
    if let Some(note) = contents.note(&path.display().to_string()) {
        report.warn_nowhere(note);
    }
    reader.shapes(contents);
    precision::check(&reader.parts, 0.0, report);
    let size = options.size.unwrap_or([768, 576]);
    let camera = framing::frame(&reader.parts, &options.camera, size, report)?;
    let presets: BTreeMap<String, String> =
        options.defines.iter().filter(|(n, _)| n.starts_with("gi.")).cloned().collect();
    let world = reader.hash.value();
    for (name, value) in &options.defines {
        reader.hash.bytes(name.as_bytes());
        reader.hash.bytes(value.as_bytes());
    }
    Some(Loaded {
        parts: reader.parts,
        camera,
        filter: Filter::Gaussian { stddev: 0.5 },
        presets,
        integrator_max_depth: None,
        warnings: Vec::new(),
        hash: reader.hash.value(),
        world,
        files: Vec::new(),
        memory: 0,
        origins: reader.origins,
    })
}

/// Warn about options that have no effect on OBJ files.
fn warn_of_unused(options: &Options, report: &Report) {
    for (name, _) in options.defines.iter().filter(|(name, _)| !name.starts_with("gi.")) {
        report.warn_nowhere(format!("-D {name} has no effect: OBJ files have no named values"));
    }
    if let Some(index) = options.sensor {
        report.warn_nowhere(format!("--sensor {index} has no effect: OBJ files have no sensors"));
    }
}

struct Reader<'a> {
    report: &'a Report,
    folder: PathBuf,
    hash: Hash,
    parts: SceneParts,
    origins: Origins,
    pictures: Pictures,
    folders: Folders,
}

/// The materials of all libraries, by name.
#[derive(Default)]
struct Library {
    entries: Vec<Entry>,
    by_name: HashMap<String, usize>,
}

impl Library {
    /// Add entries; if two have the same name, the first one wins.
    fn extend(&mut self, entries: Vec<Entry>) {
        let first = self.entries.len();
        self.entries.extend(entries);
        for k in first..self.entries.len() {
            self.by_name.entry(self.entries[k].name.clone()).or_insert(k);
        }
    }

    /// Index each name without its trailing comment too. A name with the full text takes precedence.
    fn index_comments(&mut self) {
        for (k, entry) in self.entries.iter().enumerate() {
            if let Some(short) = name_before_comment(&entry.name) {
                self.by_name.entry(short.to_owned()).or_insert(k);
            }
        }
    }

    fn get(&self, name: &str) -> Option<&Entry> {
        let known = |name: &str| self.by_name.get(name).map(|k| &self.entries[*k]);
        known(name).or_else(|| known(name_before_comment(name)?))
    }
}

impl Reader<'_> {
    /// Read the file's meshes, one per material.
    fn read(&mut self, path: &Path) -> Result<obj::Contents, String> {
        let (mut text, mut meshes) =
            (self.report.budget.claim(path.display()), self.report.budget.claim(path.display()));
        let bytes = files::read_bytes(path, &mut text)?;
        self.hash.bytes(&bytes);
        let mut parse =
            |origin| guarded(|| obj::parse_by_material(&bytes, (true, origin), true, &mut meshes));
        let mut contents = parse(DVec3::ZERO)?;
        let bounds = contents.meshes.iter().map(|(_, mesh)| mesh.bounds());
        let bounds = bounds.fold(Bounds::EMPTY, Bounds::union);
        let ends = [bounds.min, bounds.max].map(|p| p.as_dvec3());
        let origin = Extent::of(ends).map_or(DVec3::ZERO, |all| all.origin());
        if !bounds.is_empty() && origin != DVec3::ZERO {
            // Again, with all digits that the file has.
            drop(contents);
            contents = parse(origin)?;
            self.parts.origin = origin.as_vec3();
        }
        meshes.keep(contents.meshes.iter().map(|(_, mesh)| mesh_file::bytes(mesh)).sum())?;
        Ok(contents)
    }

    fn shapes(&mut self, contents: obj::Contents) {
        let library = self.libraries(&contents.libraries);
        let unknown = Entry::default();
        for (name, mut mesh) in contents.meshes {
            let known = library.get(&name);
            if known.is_none() && !name.is_empty() {
                self.report.warn_nowhere(format!(
                    "no library defines the material `{name}`: it becomes grey"
                ));
            }
            let entry = known.unwrap_or(&unknown);
            let (material, emission) = (self.material(entry), self.emission(entry));
            let replaced = smooth::replace_bad_normals(&mut mesh);
            if replaced > 0 {
                let name = if name.is_empty() { "the mesh" } else { &name };
                self.report.warn_nowhere(smooth::bad_normals(replaced, name));
            }
            // Smooth normals would show seams where materials meet, so a mesh without `vn` is shaded flat.
            let mut shape = Shape::new(name, Geometry::Mesh(mesh), material);
            shape.emission = emission;
            self.parts.shapes.push(shape);
            self.origins.shapes.push(ShapeOrigin::Itself);
        }
        if self.parts.shapes.is_empty() {
            self.report.error_nowhere("the file contains no faces");
        }
    }

    /// Read all libraries that `mtllib` statements name.
    fn libraries(&mut self, statements: &[String]) -> Library {
        let (mut library, mut done) = (Library::default(), HashSet::new());
        for statement in statements {
            for name in self.library_names(statement) {
                let Some(path) = pictures::find(&self.folders, &name, &self.folder) else {
                    let message = format!("cannot find the material library `{name}`");
                    self.report.warn_nowhere(message);
                    continue;
                };
                if done.insert(path.clone()) {
                    library.extend(self.library(&path));
                }
            }
        }
        library.index_comments();
        library
    }

    /// The names in a statement: the whole text if a file has that name, otherwise its words.
    fn library_names(&self, statement: &str) -> Vec<String> {
        let exists = |name: &&str| pictures::find(&self.folders, name, &self.folder).is_some();
        let short = name_before_comment(statement);
        if let Some(name) = [Some(statement), short].into_iter().flatten().find(exists) {
            return vec![name.to_owned()];
        }
        // If no word names a file either, report the whole text as missing.
        let words = || short.unwrap_or(statement).split_whitespace();
        match words().any(|word| exists(&word)) {
            true => words().map(str::to_owned).collect(),
            false => vec![statement.to_owned()],
        }
    }

    fn library(&mut self, path: &Path) -> Vec<Entry> {
        let mut claim = self.report.budget.claim(path.display());
        let bytes = files::read_bytes(path, &mut claim).and_then(|bytes| {
            claim.keep(4 * bytes.len() as u64)?; // the text and its entries
            Ok(bytes)
        });
        let bytes = match bytes {
            Ok(bytes) => bytes,
            Err(why) => {
                self.report.error_nowhere(format!("cannot read `{}`: {why}", path.display()));
                return Vec::new();
            }
        };
        self.hash.bytes(&bytes);
        let bytes = files::without_mark(&bytes);
        let text = String::from_utf8(bytes.to_vec()).unwrap_or_else(|_| latin_1(&bytes));
        let file = self.report.add_file(path, &text);
        mtl::parse(&text, file, self.report)
    }
}

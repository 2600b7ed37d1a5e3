//! Writes one figure as `figure.json`: its panels, its caption, where its pictures came from, and the claims that its data
//! was checked for.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, bail};
use serde_json::{Map, Value, json};

use crate::data::Data;
use crate::expr::{check as check_claim, filled};
use crate::inset::Inset;
use crate::picture::Picture;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The figure's folder, which contains its panels
    folder: PathBuf,
    /// Slides that the figure belongs to: 12, or 29-30
    #[arg(long)]
    slide: String,
    #[arg(long)]
    title: String,
    /// The caption: what to see, and why. {EXPRESSION} becomes a number, as in the captions of panels
    #[arg(long)]
    caption: String,
    /// Number of columns of panels
    #[arg(long, default_value_t = 3)]
    columns: u32,
    /// Picture to compare all others of its size with
    #[arg(long)]
    reference: Option<PathBuf>,
    /// Layer to compare: Direct, Indirect, Caustic [default: all light]
    #[arg(long)]
    layer: Option<String>,
    /// Compare only a part of the pictures, such as all but the lamp: left, top, width and height as fractions
    #[arg(long, value_name = "X,Y,W,H", value_delimiter = ',')]
    part: Vec<f64>,
    /// Brighten the pictures, compared to the programs' display images, by this power of two
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f32,
    /// What must be true for the caption to be right: a comparison of two expressions by < or >, or "EXPRESSION in LOW..HIGH".
    /// The figure fails if it is false
    #[arg(long = "claim")]
    claims: Vec<String>,
    /// Enlarge a part of every picture in its corner: left, top, width and height as fractions of the picture, and the factor
    #[arg(long = "inset", value_name = "X,Y,W,H,ZOOM")]
    insets: Vec<Inset>,
    /// Pictures (.png) and drawings (.svg), with the captions below them
    #[arg(value_name = "FILE=CAPTION", required = true)]
    panels: Vec<Panel>,
}

/// A picture or drawing with its caption.
#[derive(Clone, Debug)]
struct Panel {
    file: String,
    caption: String,
}

impl FromStr for Panel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (file, caption) = text.split_once('=').ok_or("expected FILE=CAPTION")?;
        Ok(Panel { file: file.into(), caption: caption.into() })
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let told = || format!("slide {}", args.slide);
    let layer = args.layer.as_deref();
    let data = Data { folder: &args.folder, reference: args.reference.as_deref(), layer };
    let reference = args.reference.as_ref().map(|path| Picture::read(path, layer)).transpose()?;
    let mut panels = Vec::new();
    for panel in &args.panels {
        let caption = filled(&panel.caption, &data).with_context(told)?;
        let panel = Panel { caption, ..panel.clone() };
        let described = describe(args, &panel, reference.as_ref())
            .with_context(|| format!("slide {}: {}", args.slide, panel.file))?;
        panels.push(described);
    }
    let figure = json!({
        "slide": args.slide,
        "title": args.title,
        "caption": filled(&args.caption, &data).with_context(told)?,
        "columns": args.columns,
        "reference": args.reference.as_ref().map(|p| p.display().to_string()),
        "claims": claims(args, &data).with_context(told)?,
        "panels": panels,
    });
    let out = args.folder.join("figure.json");
    std::fs::write(&out, format!("{figure:#}\n")).with_context(|| out.display().to_string())
}

/// Check all claims; the error lists all that are false.
fn claims(args: &Args, data: &Data) -> anyhow::Result<Vec<Value>> {
    let (mut claims, mut wrong) = (Vec::new(), Vec::new());
    for claim in &args.claims {
        let checked = check_claim(claim, data)?;
        if !checked.holds {
            wrong.push(format!("the claim \"{claim}\" is false: {}", checked.numbers));
        }
        claims.push(json!({ "claim": claim, "numbers": checked.numbers }));
    }
    if !wrong.is_empty() {
        bail!("{}", wrong.join("; "));
    }
    Ok(claims)
}

/// Check a panel, and describe how it was made, from the data of its picture.
fn describe(args: &Args, panel: &Panel, reference: Option<&Picture>) -> anyhow::Result<Value> {
    let file = args.folder.join(&panel.file);
    check(&file)?;
    let mut told = Map::new();
    told.insert("file".into(), panel.file.clone().into());
    told.insert("caption".into(), panel.caption.clone().into());
    if let Some(data) = data_behind(&file) {
        let picture = Picture::read(&data, None)?;
        if picture.rgb.iter().all(|v| *v == 0.0) {
            bail!("{} is black", data.display());
        }
        told.insert("data".into(), name_of(&data).into());
        for (key, name) in [
            ("command", "command"),
            ("scene", "scene"),
            ("seed", "seed"),
            ("passes", "passes"),
            ("seconds", "seconds"),
            ("reach", "reach"),
        ] {
            if let Some(value) = picture.said(name) {
                told.insert(key.into(), value.into());
            }
        }
        let own = file.file_stem() == data.file_stem();
        if own && (args.exposure != 0.0 || !args.insets.is_empty()) {
            picture.save_view(&file, args.exposure, &args.insets)?;
        }
        if own && args.exposure != 0.0 {
            told.insert("exposure".into(), json!(args.exposure));
        }
        // The panel that shows the reference itself has no error.
        let compared = own && name_of(&data) != "reference.exr";
        if let Some(reference) = reference.filter(|r| compared && r.size == picture.size) {
            let picture = Picture::read(&data, args.layer.as_deref())?.asked_part(&args.part)?;
            let errors = picture.errors(&reference.clone().asked_part(&args.part)?)?;
            told.insert("relmse".into(), json!(errors.rel_mse));
            told.insert("mean_ratio".into(), json!(errors.mean_ratio));
        }
    }
    Ok(told.into())
}

/// Check that a panel exists, is a picture or a drawing, and is complete.
fn check(file: &Path) -> anyhow::Result<()> {
    let bytes = std::fs::read(file).context("cannot be read")?;
    let sound = match file.extension().and_then(|e| e.to_str()) {
        Some("png") => bytes.starts_with(b"\x89PNG") && bytes.ends_with(b"IEND\xaeB`\x82"),
        Some("svg") => bytes.starts_with(b"<svg") && bytes.trim_ascii_end().ends_with(b"</svg>"),
        _ => bail!("neither .png nor .svg"),
    };
    if !sound {
        bail!("is incomplete");
    }
    Ok(())
}

/// The EXR of a picture: `a.exr` of `a.png`, and of the technique's own `a.records.png`.
fn data_behind(file: &Path) -> Option<PathBuf> {
    let name = file.file_name()?.to_str()?;
    let mut stem = name.strip_suffix(".png")?;
    loop {
        let data = file.with_file_name(format!("{stem}.exr"));
        if data.is_file() {
            return Some(data);
        }
        // Names may contain dots: alpha-0.7.radius.png belongs to alpha-0.7.exr.
        stem = stem.rsplit_once('.')?.0;
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

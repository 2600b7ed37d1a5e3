//! Writes the display image of a picture, or of one of its layers.

use std::path::PathBuf;

use crate::picture::Picture;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The display image to write (.png)
    out: PathBuf,
    /// The picture
    picture: PathBuf,
    /// Layer to show: Direct, Indirect, Caustic [default: all light]
    #[arg(long)]
    layer: Option<String>,
    /// Brighten by this power of two
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f32,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    Picture::read(&args.picture, args.layer.as_deref())?.save_view(&args.out, args.exposure, &[])
}

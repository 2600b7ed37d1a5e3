//! Writes the errors of pictures against a reference as a table.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Context;

use crate::Named;
use crate::picture::Picture;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The table to write
    out: PathBuf,
    /// The reference picture
    #[arg(long)]
    reference: PathBuf,
    /// Layer of all pictures: Direct, Indirect, Caustic [default: all light]
    #[arg(long)]
    layer: Option<String>,
    /// Pictures, each with its number for the column x
    #[arg(value_name = "X=PICTURE", required = true)]
    pictures: Vec<Named>,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let layer = args.layer.as_deref();
    let reference = Picture::read(&args.reference, layer)?;
    let mut table = String::from("x,seconds,relmse,rmse,ratio_r,ratio_g,ratio_b\n");
    for Named { name, file } in &args.pictures {
        let picture = Picture::read(file, layer)?;
        let e = picture.errors(&reference).with_context(|| file.display().to_string())?;
        let seconds = picture.said("seconds").unwrap_or("");
        let [r, g, b] = e.mean_ratio;
        writeln!(table, "{name},{seconds},{:.6e},{:.6e},{r:.5},{g:.5},{b:.5}", e.rel_mse, e.rmse)?;
    }
    std::fs::write(&args.out, table).with_context(|| args.out.display().to_string())
}

//! Writes the errors of pictures against a reference as a table.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

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
    /// Measure only a part of the pictures: left, top, width and height as fractions
    #[arg(long, value_name = "X,Y,W,H", value_delimiter = ',')]
    part: Vec<f64>,
    /// Pictures, each with its number for the column x. With two pictures, of different seeds, noise and bias are told apart
    #[arg(value_name = "X=PICTURE[,PICTURE]", required = true)]
    pictures: Vec<Named>,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let reference = read(args, &args.reference)?;
    let mut table =
        String::from("x,seconds,pass_seconds,relmse,rmse,ratio_r,ratio_g,ratio_b,noise,bias\n");
    for Named { name, file } in &args.pictures {
        let files = file.to_string_lossy();
        let pictures = files.split(',').map(|f| read(args, Path::new(f)));
        let pictures = pictures.collect::<anyhow::Result<Vec<_>>>()?;
        let errors = pictures.iter().map(|p| p.errors(&reference));
        let errors = errors.collect::<Result<Vec<_>, _>>().with_context(|| files.to_string())?;
        let seconds = pictures[0].said("seconds").unwrap_or("");
        let number = |name| pictures[0].said(name).and_then(|text| text.parse::<f64>().ok());
        let of_a_pass =
            number("seconds").zip(number("passes")).map(|(s, n)| format!("{:.6}", s / n));
        let of_a_pass = of_a_pass.unwrap_or_default();
        let mean = |of: &dyn Fn(usize) -> f64| {
            (0..errors.len()).map(of).sum::<f64>() / errors.len() as f64
        };
        let [r, g, b] = [0, 1, 2].map(|k| mean(&|i| errors[i].mean_ratio[k]));
        let (relative, rmse) = (mean(&|i| errors[i].rel_mse), mean(&|i| errors[i].rmse));
        write!(
            table,
            "{name},{seconds},{of_a_pass},{relative:.6e},{rmse:.6e},{r:.5},{g:.5},{b:.5},"
        )?;
        match &pictures[..] {
            [a, b] => {
                let [noise, bias] = apart(a, b, &reference);
                writeln!(table, "{noise:.6e},{bias:.6e}")?;
            }
            [_] => writeln!(table, ",")?,
            _ => bail!("{name}: expected one picture or two"),
        }
    }
    std::fs::write(&args.out, table).with_context(|| args.out.display().to_string())
}

fn read(args: &Args, path: &Path) -> anyhow::Result<Picture> {
    Picture::read(path, args.layer.as_deref())?.asked_part(&args.part)
}

/// The squares of noise and bias, relative like relMSE, from two pictures with independent noise: their half squared difference has
/// the mean of the noise alone, and the product of their errors has the mean of the bias alone.
fn apart(a: &Picture, b: &Picture, reference: &Picture) -> [f64; 2] {
    let (mut noise, mut bias) = (0.0, 0.0);
    for ((a, b), r) in a.rgb.iter().zip(&b.rgb).zip(&reference.rgb) {
        let [a, b, r] = [a, b, r].map(|v| f64::from(*v));
        let floor = r * r + gi_stats::metrics::RELATIVE_FLOOR;
        noise += 0.5 * (a - b).powi(2) / floor;
        bias += (a - r) * (b - r) / floor;
    }
    [noise, bias].map(|v| v / reference.rgb.len() as f64)
}

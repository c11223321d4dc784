//! Arguments of `nephroid validate`.

use std::path::PathBuf;

use super::super::args::{CacheArgs, parse_define, parse_fraction, parse_shard};
use crate::reference::shard::Shard;
use crate::study::file::StudyCandidate;
use crate::study::limit::{self, StudyLimit};

/// `nephroid validate`.
#[derive(Debug, clap::Args)]
pub struct ValidateArgs {
    /// The scene, Mitsuba 3 XML, or a study, TOML
    #[arg(value_name = "SCENE.xml|STUDY.toml")]
    pub study: PathBuf,

    /// Set a parameter of the scene file (its `$NAME`)
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parse_define)]
    pub define: Vec<(String, String)>,

    /// The folder of the report and its films; made where missing [default: out/NAME.report]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,

    /// A sensor to fill, by id; may be given again [default: the study's, else the first irradiancemeter,
    /// else the first camera]
    #[arg(long, value_name = "ID")]
    pub sensor: Vec<String>,

    /// Judge an EXR rendered elsewhere, too, on the only sensor or on the one that is named; may be given
    /// again
    #[arg(long, value_name = "NAME[@SENSOR]=FILE.exr", value_parser = parse_candidate)]
    pub candidate: Vec<StudyCandidate>,

    /// Exit code 1 if a figure of a method or candidate is above this (or the truth cannot tell), on every
    /// sensor that has it or on the one named: mine=5%, mine:displaced=2texels, mine@floor:energy=10%; may be
    /// given again
    #[arg(long, value_name = "NAME[@SENSOR][:FIGURE]=LIMIT", value_parser = parse_limit)]
    pub max_error: Vec<StudyLimit>,

    /// The difference that matters, relative to the truth's mean [default: the study's, else 1%]
    #[arg(long, value_name = "FRACTION", value_parser = parse_fraction)]
    pub margin: Option<f64>,

    /// Make each run so often, for the median of its seconds [default: the study's, else 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeats: Option<u32>,

    /// The folder of tables
    #[command(flatten)]
    pub cache: CacheArgs,

    /// Threads [default: all cores]; figures do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Make only part K of N of the runs, and no report; parts may run at once on machines that share the
    /// folder. The command without this flag then writes the report
    #[arg(long, value_name = "K/N", value_parser = parse_shard, conflicts_with_all = ["list", "json"])]
    pub shard: Option<Shard>,

    /// List the runs, and which of them are done, and make none
    #[arg(long)]
    pub list: bool,

    /// Print the figures as JSON: what is written as report.json
    #[arg(long)]
    pub json: bool,
}

fn named(text: &str, allowed: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => {
            Ok((name.to_owned(), value.to_owned()))
        }
        _ => Err(format!("give {allowed}")),
    }
}

fn parse_candidate(text: &str) -> Result<StudyCandidate, String> {
    let allowed = "NAME=FILE.exr or NAME@SENSOR=FILE.exr, as in mine=out/mine.exr";
    let (name, file) = named(text, allowed)?;
    StudyCandidate::named(&name, file).ok_or_else(|| format!("give {allowed}"))
}

fn parse_limit(text: &str) -> Result<StudyLimit, String> {
    let limit = text
        .split_once('=')
        .and_then(|(name, value)| StudyLimit::parse(name, value));
    limit.ok_or_else(|| format!("give {}", limit::ALLOWED))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_and_candidates_have_names() {
        assert_eq!(parse_limit("mine=5%").unwrap().limit.most, 0.05);
        assert!(parse_limit("5%").is_err());
        assert!(parse_limit("mine=0").is_err());
        let named = |text: &str| {
            let found = parse_candidate(text)?;
            Ok::<_, String>((found.name, found.sensor, found.file))
        };
        assert_eq!(
            named("a=b=c.exr"),
            Ok(("a".to_owned(), None, "b=c.exr".into()))
        );
        assert_eq!(
            named("a@floor=b.exr"),
            Ok(("a".to_owned(), Some("floor".to_owned()), "b.exr".into()))
        );
        assert!(parse_candidate("@floor=b.exr").is_err());
        assert!(parse_candidate("a@=b.exr").is_err());
        assert!(parse_candidate("=x").is_err());
    }
}

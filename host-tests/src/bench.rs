//! Instructions of one tick on the flight computer: kf-core compared with published filters.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use model::Model;
use pylon::fly::{Program, build, emulate};
use serde::Serialize;

/// Timeout; the benchmark takes seconds.
const PATIENCE: Duration = Duration::from_secs(300);
/// First line of the image's output.
const HEADER: &str = "name,role,mean,least,most,h_m,bias_master_m,bias_slave_m,bias_baro_m,agrees";

/// Role of a measured filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// kf-core.
    Ours,
    /// A published filter, or the textbook's form on a published matrix library.
    Peer,
    /// For comparison only: not a published one.
    Reference,
}

/// One line of the benchmark.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the filter.
    pub name: String,
    /// Its role.
    pub role: Role,
    /// Instructions of one tick: mean of all ticks.
    pub mean: f64,
    /// The cheapest tick.
    pub least: u32,
    /// The most expensive tick.
    pub most: u32,
    /// Whether its results match the textbook's; `None` where the problem is a different one.
    pub agrees: Option<bool>,
}

/// Builds the benchmark's image, runs it in QEMU and reads its output.
///
/// # Errors
/// The image does not build or run, or the filters do not agree with each other.
pub fn run() -> Result<Vec<Row>> {
    let image = build(Program::Bench, &Model::paper(), None)?;
    let directory = image.parent().context("the image has no directory")?;
    let emulation = emulate(&image, directory, None, PATIENCE)?;
    let printed = String::from_utf8_lossy(&emulation.stdout);
    let rows =
        parse(&printed).with_context(|| format!("the benchmark printed: {printed}{}", emulation.stderr))?;
    ensure!(emulation.code == Some(0), "the benchmark's filters do not agree: {printed}");
    Ok(rows)
}

fn parse(printed: &str) -> Result<Vec<Row>> {
    let mut lines = printed.lines();
    ensure!(lines.next() == Some(HEADER), "no table");
    let rows: Vec<Row> =
        lines.map(|line| row(line).with_context(|| line.to_owned())).collect::<Result<_>>()?;
    ensure!(!rows.is_empty(), "an empty table");
    Ok(rows)
}

fn row(line: &str) -> Result<Row> {
    let cells: Vec<&str> = line.split(',').collect();
    let [name, role, mean, least, most, _, _, _, _, agrees] = cells[..] else {
        anyhow::bail!("{} cells", cells.len());
    };
    Ok(Row {
        name: name.to_owned(),
        role: match role {
            "ours" => Role::Ours,
            "peer" => Role::Peer,
            "reference" => Role::Reference,
            other => anyhow::bail!("role {other}"),
        },
        mean: mean.parse()?,
        least: least.parse()?,
        most: most.parse()?,
        agrees: match agrees {
            "yes" => Some(true),
            "no" => Some(false),
            "" => None,
            other => anyhow::bail!("agrees {other}"),
        },
    })
}

/// The row with that name.
///
/// # Errors
/// There is no such row.
pub fn named<'a>(rows: &'a [Row], name: &str) -> Result<&'a Row> {
    rows.iter().find(|row| row.name == name).with_context(|| format!("the benchmark has no {name}"))
}

/// The cheapest peer.
///
/// # Errors
/// There is no peer.
pub fn cheapest_peer(rows: &[Row]) -> Result<&Row> {
    rows.iter()
        .filter(|row| row.role == Role::Peer)
        .min_by(|a, b| a.mean.total_cmp(&b.mean))
        .context("the benchmark has no peers")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRINTED: &str = "name,role,mean,least,most,h_m,bias_master_m,bias_slave_m,bias_baro_m,agrees\n\
        book,peer,819,819,819,2048.695,13.2,-71.2,-99.0,yes\n\
        crate,peer,700.5,600,800,2048.695,13.2,-71.2,-99.0,yes\n\
        clever,reference,314,314,314,2048.695,13.2,-71.2,-99.0,yes\n\
        kf-core,ours,236.005,228,334,2048.694,13.2,-71.2,-99.0,\n";

    #[test]
    fn reads_the_table_and_finds_the_cheapest_peer() {
        let rows = parse(PRINTED).unwrap();
        assert_eq!(rows.len(), 4);
        assert_eq!(cheapest_peer(&rows).unwrap().name, "crate");
        assert_eq!(named(&rows, "kf-core").unwrap().most, 334);
        assert_eq!(named(&rows, "kf-core").unwrap().agrees, None);
        assert!(named(&rows, "nobody").is_err());
    }

    #[test]
    fn refuses_what_is_no_table() {
        assert!(parse("").is_err());
        assert!(parse("bench: panicked\n").is_err());
        assert!(parse(&PRINTED.replace("peer", "friend")).is_err());
        assert!(parse(&PRINTED.replace("819,819", "819")).is_err());
        assert!(parse(PRINTED.lines().next().unwrap()).is_err());
    }
}

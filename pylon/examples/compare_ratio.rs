//! How long `compare` takes against merely parsing the same file with the csv crate.
//!
//! `cargo run --release -p pylon --example compare_ratio -- FLIGHT.csv`: best of five each, one process.

use std::path::Path;
use std::time::{Duration, Instant};

use pylon::compare::{Options, compare};
use pylon::replay::Replay;

fn best(
    mut work: impl FnMut() -> Result<(), Box<dyn std::error::Error>>,
) -> Result<Duration, Box<dyn std::error::Error>> {
    let mut best = Duration::MAX;
    for _ in 0..5 {
        let start = Instant::now();
        work()?;
        best = best.min(start.elapsed());
    }
    Ok(best)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).ok_or("expected a flight's CSV")?;
    let file = Path::new(&file);
    let mut rows = 0_u64;
    let parse = best(|| {
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(file)?;
        let mut record = csv::ByteRecord::new();
        rows = 0;
        while reader.read_byte_record(&mut record)? {
            rows += 1;
        }
        Ok(())
    })?;
    let read = best(|| {
        pylon::flight::read(file)?;
        Ok(())
    })?;
    let (flight, _) = pylon::flight::read(file)?;
    let model = model::Model::default();
    let replay = Replay::new(&flight, &model, None)?;
    let mission = best(|| {
        replay.run(&mut |_, _| {})?;
        Ok(())
    })?;
    let comparison = best(|| {
        compare(&replay, &Options::default(), &mut |_| {})?;
        Ok(())
    })?;
    let whole = read + comparison;
    println!("rows                          {rows}");
    println!("parsing with the csv crate    {:.3} s", parse.as_secs_f64());
    println!("reading the flight            {:.3} s", read.as_secs_f64());
    println!(
        "the mission alone             {:.3} s ({:.2} million ticks a second)",
        mission.as_secs_f64(),
        rows as f64 / mission.as_secs_f64() / 1e6
    );
    println!("comparing                     {:.3} s", comparison.as_secs_f64());
    println!("compare / parsing             {:.2}", whole.as_secs_f64() / parse.as_secs_f64());
    Ok(())
}

//! The draft of a mapping, as text.

use super::board::{Board, Guess, TimeGuess};
use crate::import::mapping::Layout;
use crate::import::mapping::quantity::Quantity;
use flight_data::{Channel, unit_slip};

/// A mapping that was guessed.
#[derive(Clone, Debug)]
pub struct Draft {
    names: Vec<String>,
    layout: Option<Layout>,
    time: Option<TimeGuess>,
    guesses: Vec<Guess>,
    /// Columns that are not assigned, with the reason and a name to keep each under; no name for one without
    /// numbers.
    unplaced: Vec<(usize, String, Option<String>)>,
    is_above_ellipsoid: bool,
    rows: usize,
    /// What could not be read in the log.
    notes: Vec<String>,
}

impl Draft {
    /// From the findings.
    pub(super) fn new(board: Board<'_>) -> Self {
        let table = board.table;
        let mut taken: Vec<String> = Vec::new();
        let mut unplaced = Vec::new();
        for (column, cells) in table.columns.iter().enumerate() {
            let aside = board.set_aside.iter().find(|(aside, _)| *aside == column);
            let is_placed = aside.is_none() && !board.is_free(column);
            if is_placed {
                continue;
            }
            let filled = cells.numbers + cells.clocks + cells.dates;
            let is_number = cells.numbers > cells.words + cells.clocks + cells.dates;
            let why = match aside {
                Some((_, why)) => why.clone(),
                None if filled + cells.words == 0 => "is empty".to_owned(),
                None if !is_number && cells.words >= filled => "has words, no numbers".to_owned(),
                None if !is_number => "has times of day or dates".to_owned(),
                None if board.is_constant(column) => "has the same value in every row".to_owned(),
                None => "could not be identified by its name, its values or physics".to_owned(),
            };
            let signal = is_number.then(|| own_name(table.name(column), &mut taken));
            unplaced.push((column, why, signal));
        }
        let mut guesses = board.guesses;
        let rank =
            |guess: &Guess| Channel::ALL.iter().position(|channel| channel.name() == guess.destination);
        guesses.sort_by_key(|guess| (rank(guess).unwrap_or(usize::MAX), guess.column));
        Self {
            names: table.names.clone(),
            layout: table.layout,
            time: board.time,
            guesses,
            unplaced,
            is_above_ellipsoid: board.is_above_ellipsoid,
            rows: table.lines.len(),
            notes: table.notes.clone(),
        }
    }

    /// The guesses.
    #[must_use]
    pub fn guesses(&self) -> &[Guess] {
        &self.guesses
    }

    /// The time base, if one was found.
    #[must_use]
    pub const fn time(&self) -> Option<&TimeGuess> {
        self.time.as_ref()
    }

    /// A column as a mapping refers to it: by its index from 1 if another has the same name.
    fn column(&self, column: usize) -> String {
        let name = self.names.get(column).map_or("", String::as_str);
        let is_unique = self.names.iter().filter(|own| *own == name).count() == 1;
        if is_unique { toml::Value::String(name.to_owned()).to_string() } else { (column + 1).to_string() }
    }

    fn signal(&self, guess: &Guess) -> String {
        let mut parts = vec![format!("column = {}", self.column(guess.column))];
        if let Some(unit) = guess.unit.filter(|_| Quantity::of(&guess.destination) != Some(Quantity::Count)) {
            parts.push(format!("unit = \"{unit}\""));
        }
        parts.extend(guess.scale.map(|scale| format!("scale = {scale:?}")));
        parts.extend(guess.offset.map(|offset| format!("offset = {offset:?}")));
        if guess.held {
            parts.push("held = true".to_owned());
        }
        format!("{} = {{ {} }}", guess.destination, parts.join(", "))
    }

    /// The mapping file; `log` and `mapping` are the files' names, for the command that reads it.
    #[must_use]
    pub fn text(&self, log: &str, mapping: &str) -> String {
        let mut text = format!(
            "# A draft, guessed from names, values and physics: read the reason above each line, correct what is wrong, and take\n\
             # the '#' away from doubtful lines that are right. Then:\n\
             #   pylon import {log} --mapping {mapping} -o flight.csv\n\
             # A value is (cell * scale + offset), in the unit; 'held' columns repeat a sample until the next one.\n\
             pylon-mapping = 1\n\n{}[flight]\n# vehicle = \"...\"\naltitude_datum = \"{}\"\n",
            self.layout.map_or_else(String::new, file_section),
            if self.is_above_ellipsoid { "ellipsoid" } else { "msl" }
        );
        text += "\n";
        match &self.time {
            None => {
                text += "# No column runs forward: give the number of rows per second instead.\n# [time]\n# \
                         rate_hz = 100\n";
            }
            Some(time) => {
                let lead = if time.is_sure { "" } else { "# " };
                text += &comment(&doubt(time.is_sure, &time.evidence));
                text += &format!("{lead}[time]\n{lead}column = {}\n", self.column(time.column));
                if let Some(unit) = time.unit {
                    text += &format!("{lead}unit = \"{unit}\"\n");
                }
            }
        }
        text += "\n[signals]\n";
        let mut said = "";
        for guess in &self.guesses {
            // All three axes have the same reason.
            if guess.evidence != said {
                text += &comment(&doubt(guess.is_sure, &guess.evidence));
            }
            said = &guess.evidence;
            text += &format!("{}{}\n", if guess.is_sure { "" } else { "# " }, self.signal(guess));
        }
        for note in &self.notes {
            text += &comment(note);
        }
        if !self.unplaced.is_empty() {
            text += "\n# Not placed. Numbers can be kept as signals under names of their own:\n";
        }
        for (column, why, signal) in &self.unplaced {
            text += &comment(&format!("{} {why}", self.quoted(*column)));
            if let Some(signal) = signal {
                text += &format!("# {signal} = {{ column = {} }}\n", self.column(*column));
            }
        }
        text
    }

    fn quoted(&self, column: usize) -> String {
        format!("'{}'", self.names.get(column).map_or("", String::as_str).replace(char::is_control, " "))
    }

    /// Summary of what was guessed, doubtful and not assigned, for the user.
    #[must_use]
    pub fn explanation(&self) -> String {
        let sure = self.guesses.iter().filter(|guess| guess.is_sure).count();
        let mut text = format!(
            "{} columns in {} rows: {sure} placed, {} doubtful (commented out), {} not placed\n",
            self.names.len(),
            self.rows,
            self.guesses.len() - sure,
            self.unplaced.len()
        );
        match &self.time {
            Some(time) => text += &format!("time: {}\n", doubt(time.is_sure, &time.evidence)),
            None => text += "time: no column runs forward\n",
        }
        for alike in self.guesses.chunk_by(|one, other| one.evidence == other.evidence) {
            let names: Vec<&str> = alike.iter().map(|guess| guess.destination.as_str()).collect();
            let why = alike.first().map_or_else(String::new, |guess| doubt(guess.is_sure, &guess.evidence));
            text += &format!("{}: {why}\n", names.join(", "));
        }
        for (column, why, _) in &self.unplaced {
            text += &format!("not placed: {} {why}\n", self.quoted(*column));
        }
        for note in &self.notes {
            text += &format!("{note}\n");
        }
        text + &self.missing()
    }

    /// What a flight needs but no sure guess provides.
    fn missing(&self) -> String {
        let has = |name: &str| self.guesses.iter().any(|guess| guess.is_sure && guess.destination == name);
        let mut needs = Vec::new();
        if self.time.as_ref().is_none_or(|time| !time.is_sure) {
            needs.push("a time base");
        }
        if !has("gps_alt_m") {
            needs.push("gps_alt_m, the reference's altitude");
        }
        let others = ["baro_pa", "baro_alt_m", "imu_slave_alt_m", "imu_master_alt_m", "accel_x_mps2"];
        if !others.into_iter().any(has) {
            needs.push("another altitude: baro_pa, baro_alt_m, imu_slave_alt_m or imu_master_alt_m");
        }
        if needs.is_empty() { String::new() } else { format!("still needed: {}\n", needs.join("; ")) }
    }
}

/// The mapping's section on the layout of the text.
fn file_section(layout: Layout) -> String {
    format!(
        "[file]\nseparator = \"{}\"\ndecimal = \"{}\"\nnames_line = {}\nfirst_line = {}\n\n",
        layout.separator.name(),
        if layout.decimal_comma { "," } else { "." },
        layout.names_line,
        layout.first_line
    )
}

fn doubt(is_sure: bool, evidence: &str) -> String {
    if is_sure { evidence.to_owned() } else { format!("DOUBTFUL: {evidence}") }
}

/// Comment lines of limited length.
fn comment(text: &str) -> String {
    const WIDTH: usize = 110;
    let (mut lines, mut line) = (String::new(), "#".to_owned());
    for word in text.replace(char::is_control, " ").split_whitespace() {
        if line.len() + 1 + word.len() > WIDTH && line.len() > 1 {
            lines += &format!("{line}\n");
            line = "#  ".to_owned();
        }
        line += " ";
        line += word;
    }
    lines + &line + "\n"
}

/// A name for a separate signal, which no other has and which is not a known column's.
fn own_name(name: &str, taken: &mut Vec<String>) -> String {
    let plain: String = name
        .chars()
        .map(|letter| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '_' })
        .collect();
    let plain = plain.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
    let is_known = plain.is_empty()
        || plain == "time_s"
        || Channel::from_name(&plain).is_some()
        || unit_slip(&plain).is_some();
    let base = if is_known { format!("logged_{plain}") } else { plain };
    let mut own = base.clone();
    let mut count = 2;
    while taken.contains(&own) {
        own = format!("{base}_{count}");
        count += 1;
    }
    taken.push(own.clone());
    own
}

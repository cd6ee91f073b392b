//! Looks for laws: every single factor and term, products of the best with every other, and the constants of the best moved.

use executor::Executor;

use super::grammar::{
    DELAYS_S, Factor, LOW_PASSES_S, Law, MOST_FACTORS, MOST_PARTS, Operator, PHASES, Power, Term, TermKind,
};
use super::length::{Chosen, parts_that_pay};
use super::screen::{Column, Score, Screen};
use super::signals::Signals;
use crate::progress::{Cancelled, Progress, step};

/// Single factors that products are made of, besides the signals themselves.
const BEAM: usize = 24;
/// Products of two that are made three of.
const SECOND_BEAM: usize = 24;
/// Laws of each number of parts whose constants are moved.
const MOVED: usize = 12;
/// Laws of each number of parts among which the stretches left out choose.
const POOL: usize = 150;
/// Two ln 2: what a bit costs in twice the log likelihood.
pub const BIT: f64 = 2.0 * std::f64::consts::LN_2;

/// A law with its score.
#[derive(Clone, Debug, PartialEq)]
pub struct Scored {
    /// The law.
    pub law: Law,
    /// Its score under the noise that was held.
    pub score: Score,
    /// Its gain less what its length costs.
    pub merit: f64,
}

/// What a search found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The best laws, the best first.
    pub laws: Vec<Scored>,
    /// The greatest number of parts that pays.
    pub parts: usize,
    /// Laws that were scored.
    pub scored: u64,
}

/// What is looked through.
pub struct Search<'a> {
    /// The signals.
    pub signals: &'a Signals,
    /// Flights that are learned from: the first so many of the signals' flights.
    pub flights: usize,
    /// Sensors that a law may act on.
    pub subjects: usize,
    /// Who does the work.
    pub executor: &'a dyn Executor,
}

/// A factor or a term with its column.
struct Made<T> {
    what: T,
    column: Column,
}

impl Search<'_> {
    /// A law's column in the learning flights, or of the flights after them.
    #[must_use]
    pub fn column(&self, law: &Law, flights: std::ops::Range<usize>) -> Option<Column> {
        let blocks = self.signals.flights.get(flights)?;
        blocks.iter().map(|blocks| blocks.law(law)).collect()
    }

    /// The best laws under a screen's noise, the best first, at most `most`, of no more parts than pay.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` says so.
    pub fn run(
        &self,
        screen: &Screen<'_>,
        most: usize,
        progress: &mut Progress<'_>,
    ) -> Result<Found, Cancelled> {
        let factors = self.made(&self.factors(), |factor| Law { factors: vec![*factor], ..Law::default() });
        let terms = self.made(&self.terms(), |term| Law { term: Some(*term), ..Law::default() });
        let mut found = self.score(screen, factors.len() + terms.len(), &|k| match factors.get(k) {
            Some(made) => (Law { factors: vec![made.what], ..Law::default() }, Some(made.column.clone())),
            None => {
                let made = &terms[k - factors.len()];
                (Law { term: Some(made.what), ..Law::default() }, Some(made.column.clone()))
            }
        });
        step(progress)?;

        // A product may show where neither of its factors does: every signal itself is multiplied with everything, and the best with all.
        let mut base: Vec<usize> = (0..factors.len())
            .filter(|k| {
                let factor = factors[*k].what;
                factor.operator == Operator::Itself && factor.power == Power::One
            })
            .collect();
        for scored in &found {
            let only = [scored.law.factors.first(), None];
            let at = only[0].and_then(|factor| factors.iter().position(|made| made.what == *factor));
            if let Some(at) = at.filter(|_| scored.law.term.is_none())
                && !base.contains(&at)
            {
                base.push(at);
            }
            if base.len() >= BEAM + self.signals.signals.len() {
                break;
            }
        }
        let width = factors.len() + terms.len();
        let mut pairs = self.score(screen, base.len() * width, &|k| {
            let (first, second) = (base[k / width], k % width);
            let left = &factors[first];
            match factors.get(second) {
                // Once in either order, and no power of the same thing twice.
                Some(right)
                    if (base.contains(&second) && second <= first)
                        || (right.what.signal == left.what.signal
                            && right.what.operator == left.what.operator) =>
                {
                    (Law::default(), None)
                }
                Some(right) => (
                    Law { factors: vec![left.what, right.what], ..Law::default() },
                    Some(product(&left.column, &right.column)),
                ),
                None => {
                    let right = &terms[second - factors.len()];
                    (
                        Law { factors: vec![left.what], term: Some(right.what), off_grid: 0 },
                        Some(product(&left.column, &right.column)),
                    )
                }
            }
        });
        step(progress)?;
        // Only the best of the products go on: those with other factors among the first.
        let best: Vec<(Law, Column)> = pairs
            .iter()
            .take(SECOND_BEAM)
            .filter_map(|scored| Some((scored.law.clone(), self.column(&scored.law, 0..self.flights)?)))
            .collect();
        let triples = self.score(screen, best.len() * width, &|k| {
            let ((law, column), third) = (&best[k / width], k % width);
            let mut law = law.clone();
            match factors.get(third) {
                Some(right)
                    if law.factors.len() < MOST_FACTORS
                        && law.factors.iter().all(|factor| {
                            factor.signal != right.what.signal || factor.operator != right.what.operator
                        }) =>
                {
                    law.factors.push(right.what);
                    (law, Some(product(column, &right.column)))
                }
                None if law.term.is_none() => {
                    let right = &terms[third - factors.len()];
                    law.term = Some(right.what);
                    (law, Some(product(column, &right.column)))
                }
                _ => (Law::default(), None),
            }
        });
        step(progress)?;
        found.append(&mut pairs);
        found.extend(triples);
        let mut kept = best_by_parts(found, POOL);
        let moved = self.moved(screen, &best_by_parts(kept.clone(), MOVED));
        step(progress)?;
        kept.extend(moved);
        sort(&mut kept);
        kept.dedup_by(|a, b| a.law == b.law);
        let parts = self.parts_that_pay(screen, &kept);
        step(progress)?;
        kept.retain(|scored| scored.law.parts() <= parts);
        let kept = best_by_parts(kept, most);
        Ok(Found { laws: kept, parts, scored: (width + (base.len() + best.len()) * width) as u64 })
    }

    /// The greatest number of parts that pays among some laws, by stretches that are left out in turn.
    fn parts_that_pay(&self, screen: &Screen<'_>, laws: &[Scored]) -> usize {
        let column = |k: usize| laws.get(k).and_then(|one| self.column(&one.law, 0..self.flights));
        let stretches = screen.by_stretch(laws.len(), &column, self.executor);
        let signals = self.signals.signals.len();
        let chosen: Vec<Chosen<'_>> = laws
            .iter()
            .zip(&stretches)
            .filter_map(|(one, stretches)| {
                Some(Chosen {
                    parts: one.law.parts(),
                    price: BIT * one.law.bits(signals, self.subjects),
                    stretches: stretches.as_ref()?,
                })
            })
            .collect();
        parts_that_pay(&chosen, MOST_PARTS)
    }

    /// The best place of each law's constants about where they are, by halves of their cells.
    fn moved(&self, screen: &Screen<'_>, laws: &[Scored]) -> Vec<Scored> {
        let mut all = Vec::new();
        for scored in laws {
            all.extend(neighbours(&scored.law, self.signals));
        }
        let scored =
            self.score(screen, all.len(), &|k| (all[k].clone(), self.column(&all[k], 0..self.flights)));
        let mut finer = Vec::new();
        for one in &best_by_parts(scored.clone(), MOVED) {
            finer.extend(neighbours(&one.law, self.signals).into_iter().filter(|law| law.off_grid <= 2));
        }
        let mut found =
            self.score(screen, finer.len(), &|k| (finer[k].clone(), self.column(&finer[k], 0..self.flights)));
        found.extend(scored);
        found
    }

    /// Scores laws, the best first; those that say nothing new are left out.
    fn score(
        &self,
        screen: &Screen<'_>,
        count: usize,
        law: &(dyn Fn(usize) -> (Law, Option<Column>) + Sync),
    ) -> Vec<Scored> {
        let scores = screen.scores(count, &|k| law(k).1, self.executor);
        let n = self.signals.signals.len();
        let mut found: Vec<Scored> = Vec::new();
        for (k, score) in scores.into_iter().enumerate() {
            // What can't pay for its length is not kept: it would be most of them.
            let Some(score) = score.filter(|score| score.gain > 2.0) else { continue };
            let law = law(k).0;
            let merit = score.gain - BIT * law.bits(n, self.subjects);
            found.push(Scored { law, score, merit });
        }
        sort(&mut found);
        found.truncate(4000);
        found
    }

    fn made<T: Copy>(&self, all: &[T], law: impl Fn(&T) -> Law) -> Vec<Made<T>> {
        let column = |what: &T| self.column(&law(what), 0..self.flights);
        all.iter().filter_map(|what| Some(Made { what: *what, column: column(what)? })).collect()
    }

    /// Every single factor.
    fn factors(&self) -> Vec<Factor> {
        let operators: Vec<Operator> =
            [Operator::Itself, Operator::Deviation, Operator::Rate, Operator::Integral]
                .into_iter()
                .chain(LOW_PASSES_S.map(Operator::LowPass))
                .chain(DELAYS_S.map(Operator::Delay))
                .collect();
        let mut factors = Vec::new();
        for (at, signal) in self.signals.signals.iter().enumerate().filter(|(_, signal)| !signal.is_heading) {
            for operator in &operators {
                let shifts = matches!(operator, Operator::Deviation | Operator::Rate | Operator::Integral);
                let is_signed = signal.is_signed || shifts;
                for power in Power::ALL {
                    let is_possible = match power {
                        Power::Inverse => signal.is_away && !shifts,
                        Power::MagnitudeOrRoot => is_signed || signal.quantiles[0].iter().all(|q| *q >= 0.0),
                        _ => true,
                    };
                    if is_possible {
                        factors.push(Factor { signal: at, operator: *operator, power, is_signed });
                    }
                }
            }
        }
        factors
    }

    /// Every single term.
    fn terms(&self) -> Vec<Term> {
        let mut terms = Vec::new();
        for (signal, of) in self.signals.signals.iter().enumerate() {
            if of.is_heading {
                for kind in [TermKind::Cosine, TermKind::SecondCosine] {
                    let turn = if kind == TermKind::Cosine { 1.0 } else { 0.5 };
                    let phase = |k: usize| turn * std::f64::consts::PI * k as f64 / PHASES as f64;
                    terms.extend((0..PHASES).map(|k| Term { signal, kind, constant: phase(k) }));
                }
                continue;
            }
            for kind in [TermKind::Above, TermKind::Excess, TermKind::Lack, TermKind::Capped] {
                terms.extend(of.quantiles[0].iter().map(|constant| Term {
                    signal,
                    kind,
                    constant: *constant,
                }));
            }
            if of.is_signed {
                for kind in [TermKind::Beyond, TermKind::ExcessEitherWay] {
                    let beyond = of.quantiles[1].iter();
                    terms.extend(beyond.map(|constant| Term { signal, kind, constant: *constant }));
                }
            }
        }
        terms
    }
}

/// The law with one of its constants moved, by quarters of the way to its neighbours on the grid.
fn neighbours(law: &Law, signals: &Signals) -> Vec<Law> {
    let mut moved = Vec::new();
    let mut push = |change: &dyn Fn(&mut Law)| {
        let mut other = law.clone();
        change(&mut other);
        other.off_grid += 1;
        moved.push(other);
    };
    for (k, factor) in law.factors.iter().enumerate() {
        if let Operator::LowPass(time_s) = factor.operator {
            for share in [0.59, 0.77, 1.3, 1.7] {
                push(&|law| law.factors[k].operator = Operator::LowPass(time_s * share));
            }
        }
        if let Operator::Delay(delay_s) = factor.operator {
            for share in [0.59, 0.77, 1.3, 1.7] {
                push(&|law| law.factors[k].operator = Operator::Delay(delay_s * share));
            }
        }
    }
    if let Some(term) = law.term {
        let cell = match term.kind {
            TermKind::Cosine => std::f64::consts::PI / PHASES as f64,
            TermKind::SecondCosine => 0.5 * std::f64::consts::PI / PHASES as f64,
            kind => {
                let of = signals.signals.get(term.signal).map(|signal| &signal.quantiles);
                let is_magnitude = matches!(kind, TermKind::Beyond | TermKind::ExcessEitherWay);
                let quantiles = of.map(|of| &of[usize::from(is_magnitude)]);
                let ends = quantiles.and_then(|q| Some(q.last()? - q.first()?));
                ends.unwrap_or(0.0) / 8.0
            }
        };
        for share in [-0.5, -0.25, 0.25, 0.5] {
            push(&|law| {
                if let Some(term) = &mut law.term {
                    term.constant += share * cell;
                }
            });
        }
    }
    moved
}

/// The best laws of each number of parts, so many of each, the best first.
fn best_by_parts(mut laws: Vec<Scored>, most: usize) -> Vec<Scored> {
    sort(&mut laws);
    let mut counts = [0; MOST_PARTS + 1];
    laws.retain(|scored| {
        let count = &mut counts[scored.law.parts().min(MOST_PARTS)];
        *count += 1;
        *count <= most
    });
    laws
}

fn product(left: &Column, right: &Column) -> Column {
    let of = |(left, right): (&Vec<f64>, &Vec<f64>)| left.iter().zip(right).map(|(a, b)| a * b).collect();
    left.iter().zip(right).map(of).collect()
}

fn sort(found: &mut [Scored]) {
    found.sort_by(|a, b| b.merit.total_cmp(&a.merit));
}

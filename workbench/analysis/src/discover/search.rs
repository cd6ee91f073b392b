//! Searches for laws: every single factor and term, products of the best with every other, and the best with
//! their constants moved.

use executor::Executor;

use super::grammar::{
    DELAYS_S, Factor, LOW_PASSES_S, Law, MOST_FACTORS, MOST_PARTS, Operator, PHASES, Power, Term, TermKind,
};
use super::length::{Chosen, parts_that_pay};
use super::screen::{Column, Score, Screen};
use super::signals::Signals;
use crate::progress::{Cancelled, Progress, step};

/// Number of single factors used for products, besides the signals themselves.
const BEAM: usize = 24;
/// Number of products of two that are extended to three.
const SECOND_BEAM: usize = 24;
/// Number of laws, for each number of parts, whose constants are moved.
const MOVED: usize = 12;
/// Number of laws, for each number of parts, from which the left-out stretches choose.
const POOL: usize = 150;
/// Two ln 2: the cost of a bit in twice the log likelihood.
pub const BIT: f64 = 2.0 * std::f64::consts::LN_2;

/// A law with its score.
#[derive(Clone, Debug, PartialEq)]
pub struct Scored {
    /// The law.
    pub law: Law,
    /// Its score under the fixed noise.
    pub score: Score,
    /// Its gain less the cost of its length.
    pub merit: f64,
}

/// The result of a search.
#[derive(Clone, Debug)]
pub struct Found {
    /// The best laws, the best first.
    pub laws: Vec<Scored>,
    /// The largest number of parts that pays.
    pub parts: usize,
    /// Number of laws that were scored.
    pub scored: u64,
}

/// What is searched.
pub struct Search<'a> {
    /// The signals.
    pub signals: &'a Signals,
    /// Number of flights that are learned from: the first of the signals' flights.
    pub flights: usize,
    /// Number of sensors that a law may act on.
    pub subjects: usize,
    /// Runs the work.
    pub executor: &'a dyn Executor,
}

/// A factor or a term with its column.
struct Made<T> {
    what: T,
    column: Column,
}

impl Search<'_> {
    /// A law's column in the learning flights, or in the flights after them.
    #[must_use]
    pub fn column(&self, law: &Law, flights: std::ops::Range<usize>) -> Option<Column> {
        let blocks = self.signals.flights.get(flights)?;
        blocks.iter().map(|blocks| blocks.law(law)).collect()
    }

    /// The best laws under a screen's noise, the best first, at most `most`, with no more parts than pay.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` requests it.
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

        // A product may show an effect where neither of its factors does: every signal itself is multiplied
        // by everything, and the best by all.
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
                // Each pair in one order only, and no power of the same operation twice.
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
        // Only the best of the products are extended, with factors that they do not contain yet.
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

    /// The largest number of parts that pays among some laws, by stretches that are left out in turn.
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

    /// The best values of each law's constants around the present ones, by halves of their cells.
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

    /// Scores laws, the best first; those that add nothing new are left out.
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
            // Laws that cannot pay for their length are not kept: they would be most of them.
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

/// The best laws of each number of parts, at most `most` of each, the best first.
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

#[cfg(test)]
mod tests {
    use executor::Inline;

    use super::*;
    use crate::diagnose::parts::Problem;
    use crate::discover::grammar::Name;
    use crate::discover::screen::Subject;
    use crate::discover::signals::Signal;
    use crate::discover::small_flights::{BARO, WHITE, flight, noise, problem};

    const BLOCKS: usize = 240;
    /// Number of the blocks' signals that the workbench knows.
    const KNOWN: usize = 21;

    /// A flight's signals: an airspeed, a throttle and flaps, each with its own period.
    fn recorded() -> Vec<Vec<f64>> {
        (0..BLOCKS)
            .map(|k| {
                let mut block = vec![f64::NAN; KNOWN + 1];
                let time_s = k as f64;
                block[0] = 30.0 + 8.0 * libm::sin(0.13 * time_s);
                block[10] = 0.5 + 0.4 * libm::sin(0.31 * time_s + 1.0);
                block[KNOWN] = libm::sin(0.057 * time_s + 2.0);
                block
            })
            .collect()
    }

    fn names() -> Vec<String> {
        (0..KNOWN).map(|k| format!("known{k}")).chain(["flap".to_owned()]).collect()
    }

    /// The result of a search where an error of the barometer, a function of airspeed, throttle and flaps,
    /// acts in addition to a bias and noise.
    fn found(error_m: impl Fn(f64, f64, f64) -> f64) -> (Found, Vec<Name>) {
        let (blocks, mut random) = (recorded(), noise(3));
        let error = |block: &Vec<f64>| 7.0 + error_m(block[0], block[10], block[KNOWN]);
        // Uniform noise of +-0.5 m has a sigma of 0.29 m.
        let errors: Vec<f64> = blocks.iter().map(|block| error(block) + 0.5 * random()).collect();
        let flights = [flight(&errors, &[])];
        let problem: Problem<'_> = problem(&flights);
        let signals = Signals::new(&[(&flights[0], &blocks)], &names(), &[]);
        let screen = Screen::new(&problem, WHITE, &[], Subject::Sensor(BARO));
        let search = Search { signals: &signals, flights: 1, subjects: 1, executor: &Inline };
        (search.run(&screen, 10, &mut || std::ops::ControlFlow::Continue(())).unwrap(), signals.names())
    }

    fn best(found: &(Found, Vec<Name>)) -> String {
        found.0.laws[0].law.formula(&found.1)
    }

    /// The law that acts is the best one, with the number of parts that it has: a square, a product of two
    /// signals, a signal above a threshold.
    #[test]
    fn the_law_that_acts_is_found() {
        let square = found(|airspeed, _, _| 0.005 * airspeed * airspeed);
        assert_eq!((best(&square), square.0.parts), ("tas_mps^2".to_owned(), 1));
        let product = found(|airspeed, throttle, _| 0.2 * airspeed * throttle);
        assert_eq!(product.0.parts, 2);
        let names = &product.0.laws[0].law.factors;
        assert_eq!((names.len(), product.0.laws[0].law.parts()), (2, 2), "{}", best(&product));
        assert!(names.iter().all(|factor| factor.power == Power::One && factor.operator == Operator::Itself));
        // A product of flaps and the square of the airspeed, whose sign changes: neither alone explains it.
        let signed = found(|airspeed, _, flap| 0.005 * airspeed * airspeed * flap);
        let law = &signed.0.laws[0].law;
        assert!(law.parts() == 2 && law.uses(2) && law.uses(0), "{}", best(&signed));
        let laws = &square.0.laws;
        assert!(laws.windows(2).all(|pair| pair[0].merit >= pair[1].merit) && laws.len() <= 10);
        assert!(laws.iter().all(|scored| scored.law.parts() <= square.0.parts));
    }

    /// The merit is the gain less two ln 2 for each bit; and white noise contains nothing that pays for a
    /// law's length.
    #[test]
    fn a_law_pays_for_its_bits() {
        let square = found(|airspeed, _, _| 0.005 * airspeed * airspeed).0;
        for scored in &square.laws {
            let merit = scored.score.gain - 2.0 * std::f64::consts::LN_2 * scored.law.bits(3, 1);
            assert!((scored.merit - merit).abs() < 1e-9);
        }
        let nothing = found(|_, _, _| 0.0).0;
        assert!(nothing.laws.first().is_none_or(|best| best.merit < 8.0), "{:?}", nothing.laws.first());
    }

    fn signal(is_signed: bool, is_away: bool, is_heading: bool, quantiles: [Vec<f64>; 2]) -> Signal {
        let blocks = recorded();
        let flights = [flight(&[0.0; BLOCKS], &[])];
        let mut signal = Signals::new(&[(&flights[0], &blocks)], &names(), &[]).signals[0].clone();
        (signal.is_signed, signal.is_away, signal.is_heading, signal.quantiles) =
            (is_signed, is_away, is_heading, quantiles);
        signal
    }

    fn search_of(signals: Vec<Signal>) -> Signals {
        Signals { signals, ..Signals::default() }
    }

    /// Every factor that can be made of a signal: ten operators by five powers, without the inverse where the
    /// result comes near zero or was shifted; for a signal with both signs the magnitude replaces the root.
    #[test]
    fn every_factor_is_every_operator_and_power_that_can_be() {
        let count = |is_signed, is_away, quantiles: &[f64]| {
            let signals =
                search_of(vec![signal(is_signed, is_away, false, [quantiles.to_vec(), Vec::new()])]);
            let search = Search { signals: &signals, flights: 1, subjects: 1, executor: &Inline };
            let factors = search.factors();
            for factor in &factors {
                let is_shifted =
                    matches!(factor.operator, Operator::Deviation | Operator::Rate | Operator::Integral);
                assert_eq!(factor.is_signed, is_signed || is_shifted);
                assert!(factor.power != Power::Inverse || (is_away && !is_shifted));
            }
            factors.len()
        };
        let operators = 4 + LOW_PASSES_S.len() + DELAYS_S.len();
        assert_eq!(count(true, true, &[-1.0, 1.0]), 5 * operators - 3);
        assert_eq!(count(false, false, &[0.0, 1.0]), 4 * operators);
        // A signal below zero has neither a root nor, except where an operator shifts it, a magnitude.
        assert_eq!(count(false, false, &[-2.0, -1.0]), 3 * operators + 3);
        let heading = search_of(vec![signal(true, false, true, [Vec::new(), Vec::new()])]);
        let search = Search { signals: &heading, flights: 1, subjects: 1, executor: &Inline };
        assert_eq!(search.factors(), []);
    }

    /// Every term: four kinds at each quantile, two more at each quantile of the magnitude where there are
    /// both signs, and for a heading the phases over half a turn and over a quarter.
    #[test]
    fn every_term_is_every_kind_at_every_quantile() {
        let quantiles = || [vec![-1.0, 0.5, 2.0], vec![1.0, 1.5]];
        let of = |signals: &Signals| Search { signals, flights: 1, subjects: 1, executor: &Inline }.terms();
        assert_eq!(of(&search_of(vec![signal(true, false, false, quantiles())])).len(), 4 * 3 + 2 * 2);
        assert_eq!(of(&search_of(vec![signal(false, false, false, quantiles())])).len(), 4 * 3);
        let heading = of(&search_of(vec![signal(true, false, true, [Vec::new(), Vec::new()])]));
        let phases: Vec<f64> = heading.iter().map(|term| term.constant / std::f64::consts::PI).collect();
        assert_eq!(phases, [0.0, 0.25, 0.5, 0.75, 0.0, 0.125, 0.25, 0.375]);
        assert!(heading[..4].iter().all(|term| term.kind == TermKind::Cosine));
    }

    /// A constant moves by quarters of its cell either way, a time by factors that divide the grid's steps of
    /// three; each such law is marked as off the grid.
    #[test]
    fn neighbours_are_quarters_of_a_cell_away() {
        let signals = search_of(vec![signal(true, false, false, [vec![0.0, 3.0, 8.0], vec![1.0, 17.0]])]);
        let constants = |kind, constant| {
            let law = Law { term: Some(Term { signal: 0, kind, constant }), ..Law::default() };
            let moved = neighbours(&law, &signals);
            assert!(moved.iter().all(|law| law.off_grid == 1));
            moved.iter().map(|law| law.term.unwrap().constant).collect::<Vec<f64>>()
        };
        assert_eq!(constants(TermKind::Above, 3.0), [2.5, 2.75, 3.25, 3.5]);
        assert_eq!(constants(TermKind::Beyond, 5.0), [4.0, 4.5, 5.5, 6.0]);
        assert_eq!(constants(TermKind::ExcessEitherWay, 5.0), [4.0, 4.5, 5.5, 6.0]);
        let of_pi = |constants: Vec<f64>| {
            constants.into_iter().map(|value| value / std::f64::consts::PI).collect::<Vec<f64>>()
        };
        assert_eq!(of_pi(constants(TermKind::Cosine, 0.0)), [-0.125, -0.0625, 0.0625, 0.125]);
        assert_eq!(of_pi(constants(TermKind::SecondCosine, 0.0)), [-0.0625, -0.03125, 0.03125, 0.0625]);
        let factor = |operator| Factor { signal: 0, operator, power: Power::One, is_signed: true };
        let law = Law {
            factors: vec![
                factor(Operator::Itself),
                factor(Operator::LowPass(10.0)),
                factor(Operator::Delay(2.0)),
            ],
            ..Law::default()
        };
        let moved = neighbours(&law, &signals);
        let times: Vec<Operator> =
            moved.iter().enumerate().map(|(k, law)| law.factors[1 + k / 4].operator).collect();
        let wanted = [0.59, 0.77, 1.3, 1.7];
        assert_eq!(times[..4], wanted.map(|share| Operator::LowPass(10.0 * share)));
        assert_eq!(times[4..], wanted.map(|share| Operator::Delay(2.0 * share)));
    }

    /// For each number of parts this many laws are kept, the best first.
    #[test]
    fn the_best_of_every_number_of_parts_stay() {
        let factor = Factor { signal: 0, operator: Operator::Itself, power: Power::One, is_signed: true };
        let scored = |parts: usize, merit: f64| Scored {
            law: Law { factors: vec![factor; parts], ..Law::default() },
            score: Score { gain: merit, information: 1.0 },
            merit,
        };
        let laws = vec![
            scored(1, 2.0),
            scored(2, 9.0),
            scored(1, 5.0),
            scored(1, 3.0),
            scored(2, 1.0),
            scored(3, 4.0),
        ];
        let kept: Vec<(usize, f64)> =
            best_by_parts(laws, 2).iter().map(|scored| (scored.law.parts(), scored.merit)).collect();
        assert_eq!(kept, [(2, 9.0), (1, 5.0), (3, 4.0), (1, 3.0), (2, 1.0)]);
        assert_eq!(
            product(&vec![vec![1.0, 2.0], vec![3.0]], &vec![vec![5.0, 7.0], vec![-1.0]]),
            [vec![5.0, 14.0], vec![-3.0]]
        );
    }
}

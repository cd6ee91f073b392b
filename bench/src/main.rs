//! Instructions of one tick of the paper's 4-state, 4-sensor problem, for our filter and its peers, in one
//! image, counted by QEMU. It runs only in QEMU.
#![no_std]
#![no_main]

mod counter;
mod formulas;
mod ours;
mod peer_minikalman;
mod peers;
mod problem;
mod textbook;

use core::panic::PanicInfo;

use cortex_m_rt::entry;
use semihosting::process::ExitCode;
use semihosting::{eprintln, println};
use stm32f4xx_hal::pac;

use counter::{Call, Count, Counter};
use kf_core::estimator::ConfigError;
use problem::{Filter, Measurements};

/// Ticks over which each filter is measured.
const TICKS: u32 = 400;
/// Microseconds of one tick.
const TICK_US: u64 = 5_000;
/// Largest allowed distance between two filters at the end, in posterior sigmas: they differ only by
/// rounding.
const AGREEMENT_SIGMAS: f32 = 0.05;

/// One filter and the tick's measurements, so that a call takes one argument.
struct Tick<F> {
    filter: F,
    time_us: u64,
    measurements: [f32; 4],
}

impl<F: Filter> Call for Tick<F> {
    fn call(&mut self) {
        self.filter.tick(self.time_us, &self.measurements);
    }
}

/// The role in which a filter is measured.
#[derive(Clone, Copy)]
enum Role {
    /// kf-core.
    Ours,
    /// A published filter, or the textbook's form on a published matrix library.
    Peer,
    /// For comparison only: not published.
    Reference,
}

impl Role {
    const fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::Peer => "peer",
            Self::Reference => "reference",
        }
    }
}

/// The result of a filter.
struct Outcome {
    role: Role,
    name: &'static str,
    count: Count,
    state: [f32; 4],
    variances: [f32; 4],
}

fn run<F: Filter>(counter: &Counter, role: Role, name: &'static str, filter: F) -> Outcome {
    let mut source = Measurements::new();
    let mut tick = Tick { filter, time_us: 0, measurements: [0.0; 4] };
    let count = counter.count(TICKS, &mut tick, |tick| {
        tick.time_us += TICK_US;
        tick.measurements = source.next_tick();
    });
    Outcome { role, name, count, state: tick.filter.state(), variances: tick.filter.variances() }
}

/// Whether two filters ended at the same state and covariance, except for rounding.
fn agree(a: &Outcome, b: &Outcome) -> bool {
    (0..4).all(|i| {
        let apart = a.state[i] - b.state[i];
        let ratio = a.variances[i] / b.variances[i];
        apart * apart <= AGREEMENT_SIGMAS * AGREEMENT_SIGMAS * b.variances[i] && (0.99..1.01).contains(&ratio)
    })
}

#[entry]
fn main() -> ! {
    let status = match pac::Peripherals::take().and_then(|device| Counter::new(device.TIM2, &device.RCC)) {
        Some(counter) => bench(&counter),
        None => {
            eprintln!("bench: TIM2 does not count instructions; run QEMU with -icount shift=0,sleep=off");
            ExitCode::FAILURE
        }
    };
    status.exit_process()
}

/// The filters that solve the 4-state problem and must agree. The others are compared with the first.
fn four_states(counter: &Counter) -> Result<[Outcome; 11], ConfigError> {
    Ok([
        run(counter, Role::Peer, "nalgebra sequential", textbook::Sequential::<false>::new()),
        run(counter, Role::Reference, "nalgebra rank-one", textbook::Sequential::<true>::new()),
        run(counter, Role::Peer, "nalgebra dense", textbook::Dense::new()),
        run(counter, Role::Peer, "minikalman scalar", peer_minikalman::scalar()),
        run(counter, Role::Peer, "minikalman vector", peer_minikalman::vector()),
        run(counter, Role::Peer, "kfilter scalar", peers::Kfilter::<1, 4>::new()),
        run(counter, Role::Peer, "kfilter vector", peers::Kfilter::<4, 1>::new()),
        run(counter, Role::Peer, "adskalman", peers::Adskalman::new()),
        run(counter, Role::Peer, "multicalc", peers::Multicalc::new()),
        run(counter, Role::Ours, "kf-core filter", ours::UdFilter::<3, 1, 0>::new()?),
        run(counter, Role::Ours, "kf-core filter and monitors", ours::Monitored::new()?),
    ])
}

/// Further variants of ours, which have no counterpart to agree with.
fn more_of_ours(counter: &Counter) -> Result<[Outcome; 6], ConfigError> {
    let never = u64::MAX;
    Ok([
        run(counter, Role::Ours, "kf-core filter 4 effects", ours::UdFilter::<3, 5, 4>::new()?),
        run(counter, Role::Ours, "kf-core filter 4 effects dense", ours::UdFilter::<0, 8, 4>::new()?),
        run(counter, Role::Ours, "kf-core whole tick captive", ours::WholeTick::<3, 1, 0>::new(never)?),
        run(counter, Role::Ours, "kf-core whole tick free", ours::WholeTick::<3, 1, 0>::new(10)?),
        run(
            counter,
            Role::Ours,
            "kf-core whole tick 4 effects captive",
            ours::WholeTick::<3, 5, 4>::new(never)?,
        ),
        run(
            counter,
            Role::Ours,
            "kf-core whole tick 4 effects dense captive",
            ours::WholeTick::<0, 8, 4>::new(never)?,
        ),
    ])
}

fn bench(counter: &Counter) -> ExitCode {
    let (Ok(outcomes), Ok(more)) = (four_states(counter), more_of_ours(counter)) else {
        eprintln!("bench: kf-core refused its configuration");
        return ExitCode::FAILURE;
    };
    let Some(formulas) = formulas::outcomes(counter) else {
        eprintln!("bench: a formula is not a valid program");
        return ExitCode::FAILURE;
    };
    println!("name,role,mean,least,most,h_m,bias_master_m,bias_slave_m,bias_baro_m,agrees");
    let mut status = ExitCode::SUCCESS;
    for outcome in &outcomes {
        let agrees = agree(outcome, &outcomes[0]);
        print_row(outcome, if agrees { "yes" } else { "no" });
        if !agrees {
            status = ExitCode::FAILURE;
        }
    }
    for outcome in more.iter().chain(&formulas) {
        print_row(outcome, "");
    }
    status
}

fn print_row(outcome: &Outcome, agrees: &str) {
    let Count { least, most, mean } = outcome.count;
    let [h, master, slave, baro] = outcome.state;
    println!(
        "{},{},{mean},{least},{most},{h},{master},{slave},{baro},{agrees}",
        outcome.name,
        outcome.role.name()
    );
}

#[panic_handler]
fn panicked(info: &PanicInfo) -> ! {
    eprintln!("bench: {info}");
    ExitCode::FAILURE.exit_process()
}

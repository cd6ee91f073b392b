//! Instructions of one tick of the paper's 4-state, 4-sensor problem, ours beside its peers, in one
//! image, counted by QEMU. Only QEMU can run it.
#![no_std]
#![no_main]

mod counter;
mod peer_minikalman;
mod peers;
mod problem;
mod textbook;

use core::panic::PanicInfo;

use cortex_m_rt::entry;
use defmt_semihosting as _;
use semihosting::process::ExitCode;
use semihosting::{eprintln, println};
use stm32f4xx_hal::pac;

use counter::{Call, Count, Counter};
use problem::{Filter, Measurements};

/// Ticks that each filter is measured over.
const TICKS: u32 = 400;
/// How far two filters may end from each other, in posterior sigmas: they only differ by rounding.
const AGREEMENT_SIGMAS: f32 = 0.05;

/// One filter and the tick's measurements, so that a call takes one argument.
struct Tick<F> {
    filter: F,
    measurements: [f32; 4],
}

impl<F: Filter> Call for Tick<F> {
    fn call(&mut self) {
        self.filter.tick(&self.measurements);
    }
}

/// How a filter fared.
struct Outcome {
    name: &'static str,
    count: Count,
    state: [f32; 4],
    variances: [f32; 4],
}

fn run<F: Filter>(counter: &Counter, name: &'static str, filter: F) -> Outcome {
    let mut source = Measurements::new();
    let mut tick = Tick { filter, measurements: [0.0; 4] };
    let count = counter.count(TICKS, &mut tick, |tick| tick.measurements = source.next_tick());
    Outcome { name, count, state: tick.filter.state(), variances: tick.filter.variances() }
}

/// Whether two filters ended at the same state and covariance, but for rounding.
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

fn bench(counter: &Counter) -> ExitCode {
    let outcomes = [
        run(counter, "nalgebra sequential", textbook::Sequential::<false>::new()),
        run(counter, "nalgebra rank-one", textbook::Sequential::<true>::new()),
        run(counter, "nalgebra dense", textbook::Dense::new()),
        run(counter, "minikalman scalar", peer_minikalman::scalar()),
        run(counter, "minikalman vector", peer_minikalman::vector()),
        run(counter, "kfilter scalar", peers::Kfilter::<1, 4>::new()),
        run(counter, "kfilter vector", peers::Kfilter::<4, 1>::new()),
        run(counter, "adskalman", peers::Adskalman::new()),
        run(counter, "multicalc", peers::Multicalc::new()),
    ];
    println!("name,mean,least,most,h_m,bias_master_m,bias_slave_m,bias_baro_m,agrees");
    let mut status = ExitCode::SUCCESS;
    for outcome in &outcomes {
        let agrees = agree(outcome, &outcomes[0]);
        let Count { least, most, mean } = outcome.count;
        let [h, master, slave, baro] = outcome.state;
        println!("{},{mean},{least},{most},{h},{master},{slave},{baro},{agrees}", outcome.name);
        if !agrees {
            status = ExitCode::FAILURE;
        }
    }
    status
}

#[panic_handler]
fn panicked(info: &PanicInfo) -> ! {
    eprintln!("bench: {info}");
    ExitCode::FAILURE.exit_process()
}

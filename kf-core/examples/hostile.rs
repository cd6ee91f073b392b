//! Flies missions on arbitrary bits: `cargo run -p kf-core --example hostile -- [TICKS] [SEED]`, in a debug
//! build with overflow checks. Panics at the first wrong result.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, dead_code)]

#[path = "../tests/hostile/mod.rs"]
mod hostile;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>());
    let ticks = arguments.next().map_or(1_000_000, |ticks| ticks.expect("the number of ticks"));
    let seed = arguments.next().map_or(2, |seed| seed.expect("the seed"));
    let begun = std::time::Instant::now();
    let mut flown = 0;
    for part in 0.. {
        if flown >= ticks {
            break;
        }
        let now = (ticks - flown).min(1_000_000);
        let came = hostile::fly(seed.wrapping_mul(1_000_003).wrapping_add(part), now);
        flown += now;
        println!("{flown} ticks after {:.0} s; of the last {now}: {came:?}", begun.elapsed().as_secs_f64());
    }
}

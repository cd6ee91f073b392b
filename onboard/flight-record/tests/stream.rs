//! Streams that are whole, cut, garbled and invented.
#![allow(clippy::unwrap_used)]

use flight_record::{
    Decoder, Encoder, End, FrameError, Header, Kind, MAX_FRAME, MAX_STUFFED, Payload, PayloadError,
    SensorSource, Stream, TickRecord,
};
use heapless::Vec as HeaplessVec;
use kf_core::config::MAX_ESTIMATED_EFFECTS;
use kf_core::input::{BaroReading, GpsFix, ImuSample, LaunchDoubt, Signals, TickInput};
use kf_core::latch::{LatchRecord, MAX_COVARIANCE, MAX_STATES, SensorLatch};
use kf_core::output::{
    Agreement, CoefficientOutput, CrossCheckOutput, Phase, Rejection, SensorOutput, TickOutput, Trust,
};
use proptest::collection::vec;
use proptest::prelude::*;

/// An input with every field present, each at its longest encoding.
fn longest_input() -> TickInput {
    TickInput {
        time_us: u64::MAX,
        launch: true,
        launch_doubt: LaunchDoubt::Unconfirmed,
        gps: Some(GpsFix {
            altitude_m: f32::MAX,
            velocity_north_mps: Some(f32::MAX),
            velocity_east_mps: Some(f32::MAX),
            velocity_down_mps: Some(f32::MAX),
            vertical_accuracy_m: Some(f32::MAX),
            satellites: Some(u8::MAX),
            fix_time_us: Some(u64::MAX),
        }),
        baro: Some(BaroReading::PressurePa(f32::MAX)),
        imu_master_altitude_m: Some(f32::MAX),
        imu_slave_altitude_m: Some(f32::MAX),
        imu: Some(ImuSample { accel_mps2: [f32::MAX; 3], gyro_radps: [f32::MAX; 3] }),
        signals: Signals {
            true_airspeed_mps: Some(f32::MAX),
            angle_of_attack_rad: Some(f32::MAX),
            sideslip_rad: Some(f32::MAX),
            throttle: Some(f32::MAX),
            outside_air_temperature_c: Some(f32::MAX),
            baro_temperature_c: Some(f32::MAX),
            attitude_rad: Some([f32::MAX; 3]),
        },
        ..TickInput::default()
    }
}

/// A tick's record with every field present, each at its longest encoding.
fn longest_tick() -> TickRecord {
    let sensor = SensorOutput {
        bias_m: f32::MAX,
        bias_variance_m2: f32::MAX,
        innovation_m: Some(f32::MAX),
        signed_nis: Some(f32::MAX),
        error_m: Some(f32::MAX),
        moving_average_m: Some(f32::MAX),
        trust: Trust::Unmonitored,
        rejection: Some(Rejection::Variance),
    };
    let coefficient = CoefficientOutput { coefficient: f32::MAX, variance: f32::MAX };
    let output = TickOutput {
        time_us: u64::MAX,
        out_of_order: true,
        phase: Phase::FreeFlight,
        latched_now: true,
        failed_checks: u16::MAX,
        altitude_m: f32::MAX,
        altitude_variance_m2: f32::MAX,
        gps_innovation_m: Some(f32::MAX),
        gps_signed_nis: Some(f32::MAX),
        gps_rejection: Some(Rejection::Variance),
        sensors: [sensor; 3],
        extrapolated: u16::MAX,
        cross_check: Some(CrossCheckOutput {
            difference_m: f32::MAX,
            moving_average_m: f32::MAX,
            agreement: Agreement::Disagree,
        }),
        bridged_us: Some(u64::MAX),
        coefficients: HeaplessVec::from_slice(&[coefficient; MAX_ESTIMATED_EFFECTS]).unwrap(),
    };
    TickRecord { begun: u32::MAX, cost: u32::MAX, input: longest_input(), output }
}

/// A latched calibration with the largest number of states.
fn longest_latch() -> LatchRecord {
    let sensor = SensorLatch {
        bias_m: f32::MAX,
        bias_variance_m2: f32::MAX,
        readings: u32::MAX,
        residual_variance_m2: f32::MAX,
        mean_variance_m2: f32::MAX,
        bound_m2: f32::MAX,
    };
    LatchRecord {
        time_us: u64::MAX,
        duration_s: f32::MAX,
        failed_checks: u16::MAX,
        sensors: [sensor; 3],
        state: HeaplessVec::from_slice(&[f32::MAX; MAX_STATES]).unwrap(),
        covariance: HeaplessVec::from_slice(&[f32::MAX; MAX_COVARIANCE]).unwrap(),
    }
}

/// The stream of these payloads.
fn stream<P: Payload>(payloads: &[P]) -> Vec<u8> {
    let mut encoder = Encoder::new();
    let mut buffer = [0; MAX_STUFFED];
    payloads.iter().flat_map(|payload| encoder.encode(payload, &mut buffer).unwrap().to_vec()).collect()
}

/// A frame as read: the number of frames missing before it, and its payload.
type Seen<P> = Result<(u32, Result<P, PayloadError>), FrameError>;

/// What a decoder reads from these bytes.
fn read<P: Payload>(bytes: &[u8]) -> Vec<Seen<P>> {
    let mut decoder = Decoder::new();
    let mut seen = Vec::new();
    for byte in bytes {
        match decoder.push(*byte) {
            Ok(None) => {}
            Ok(Some(frame)) => seen.push(Ok((frame.missed, frame.payload()))),
            Err(error) => seen.push(Err(error)),
        }
    }
    seen
}

#[test]
fn the_longest_payloads_fit_with_room_to_spare() {
    let longest = stream(&[longest_latch()]).len();
    assert!(longest > stream(&[longest_input()]).len().max(stream(&[longest_tick()]).len()));
    assert!(longest * 5 / 4 < MAX_FRAME, "{longest}");
    assert_eq!(read(&stream(&[longest_latch()])), [Ok((0, Ok(longest_latch())))]);
    assert_eq!(read(&stream(&[longest_tick()])), [Ok((0, Ok(longest_tick())))]);
    assert_eq!(read(&stream(&[longest_input()])), [Ok((0, Ok(longest_input())))]);
}

/// The results' line of the board (docs/bring-up.md): 921,600 baud, ten bits a byte, and a tick every 5 ms.
#[test]
fn the_longest_tick_fits_into_what_the_results_line_carries_in_5_ms() {
    let longest = stream(&[longest_tick()]).len();
    println!("the longest tick's frame has {longest} bytes");
    assert!(longest < 921_600 / 10 / 200, "{longest}");
}

#[test]
fn a_header_says_its_version_whichever_it_is_and_nothing_else_does() {
    let version = |bytes: &[u8]| {
        let mut decoder = Decoder::new();
        let (last, bytes) = bytes.split_last().unwrap();
        bytes.iter().for_each(|byte| assert_eq!(decoder.push(*byte), Ok(None)));
        decoder.push(*last).unwrap().unwrap().format_version()
    };
    let header = Header { version: 1_234, ..Header::new(Stream::Outputs, 7, SensorSource::Chips) };
    assert_eq!(version(&stream(&[header])), Some(1_234));
    assert_eq!(version(&stream(&[Header { magic: *b"NONE", ..header }])), None);
    assert_eq!(version(&stream(&[End { inputs: 1 }])), None);
}

#[test]
fn nan_keeps_its_bits() {
    let bits = 0x7fa0_1234;
    let sent = TickInput { imu_slave_altitude_m: Some(f32::from_bits(bits)), ..TickInput::default() };
    let [Ok((0, Ok(got)))] = read::<TickInput>(&stream(&[sent]))[..] else { panic!() };
    assert_eq!(got.imu_slave_altitude_m.unwrap().to_bits(), bits);
}

#[test]
fn a_payload_of_another_kind_is_refused() {
    let bytes = stream(&[Header::new(Stream::Inputs, 7, SensorSource::Chips)]);
    assert_eq!(read::<End>(&bytes), [Ok((0, Err(PayloadError::Kind(Kind::Header))))]);
}

#[test]
fn a_frame_sent_twice_is_refused_the_second_time() {
    let once = stream(&[End { inputs: 1 }]);
    let twice = [once.clone(), once].concat();
    assert_eq!(read(&twice), [Ok((0, Ok(End { inputs: 1 }))), Err(FrameError::Repeated)]);
}

#[test]
fn a_cut_stream_is_known_as_cut() {
    let bytes = stream(&[End { inputs: 1 }]);
    for len in 0..=bytes.len() {
        let mut decoder = Decoder::new();
        for byte in &bytes[..len] {
            let _ = decoder.push(*byte);
        }
        assert_eq!(decoder.is_inside_frame(), len > 0 && len < bytes.len(), "{len}");
    }
}

/// Any bits, NaNs among them.
fn any_f32() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits)
}

prop_compose! {
    fn any_input()(
        time_us in any::<u64>(),
        (launch, doubt) in any::<(bool, bool)>(),
        gps in proptest::option::of((any_f32(), proptest::option::of(any_f32()), proptest::option::of(any::<u64>()))),
        baro in proptest::option::of((any::<bool>(), any_f32())),
        slave in proptest::option::of(any_f32()),
        attitude in proptest::option::of(proptest::array::uniform3(any_f32())),
    ) -> TickInput {
        TickInput {
            time_us,
            launch,
            launch_doubt: if doubt { LaunchDoubt::Suspected } else { LaunchDoubt::None },
            gps: gps.map(|(altitude_m, velocity_down_mps, fix_time_us)| GpsFix {
                altitude_m, velocity_down_mps, fix_time_us, ..GpsFix::default()
            }),
            baro: baro.map(|(pressure, value)| {
                if pressure { BaroReading::PressurePa(value) } else { BaroReading::AltitudeM(value) }
            }),
            imu_slave_altitude_m: slave,
            signals: Signals { attitude_rad: attitude, ..Signals::default() },
            ..TickInput::default()
        }
    }
}

/// The payload's bytes: if they are equal, the inputs are equal to the bit.
fn bits(input: &TickInput) -> Vec<u8> {
    postcard::to_slice(input, &mut [0; MAX_FRAME]).unwrap().to_vec()
}

proptest! {
    #[test]
    fn what_goes_in_comes_out(inputs in vec(any_input(), 0..20)) {
        let seen = read::<TickInput>(&stream(&inputs));
        prop_assert_eq!(seen.len(), inputs.len());
        for (seen, sent) in seen.into_iter().zip(&inputs) {
            let (missed, payload) = seen.unwrap();
            prop_assert_eq!(missed, 0);
            prop_assert_eq!(bits(&payload.unwrap()), bits(sent));
        }
    }

    #[test]
    fn one_garbled_byte_costs_one_frame_at_most_two(
        inputs in vec(any_input(), 3..20), at in any::<prop::sample::Index>(), garble in 1u8..
    ) {
        let mut bytes = stream(&inputs);
        let at = at.index(bytes.len());
        bytes[at] ^= garble;
        let seen = read::<TickInput>(&bytes);
        let good: Vec<_> = seen.iter().flatten().collect();
        // A lost closing zero joins two frames into one bad one.
        prop_assert!(good.len() + 2 >= inputs.len());
        prop_assert!(good.len() < inputs.len());
        let missed: u32 = good.iter().map(|(missed, _)| missed).sum();
        let lost_before_the_last_good = u32::try_from(inputs.len() - good.len()).unwrap();
        prop_assert!(missed <= lost_before_the_last_good);
        // Sequence numbers cannot show frames lost at the very end; the end frame is for that.
        let last_is_good = good.last().is_some_and(|(_, last)| {
            last.as_ref().is_ok_and(|last| bits(last) == bits(&inputs[inputs.len() - 1]))
        });
        if last_is_good && inputs.iter().rev().skip(1).all(|input| bits(input) != bits(&inputs[inputs.len() - 1])) {
            prop_assert_eq!(missed, lost_before_the_last_good);
        }
        for (_, payload) in good {
            let payload = payload.as_ref().unwrap();
            prop_assert!(inputs.iter().any(|input| bits(input) == bits(payload)));
        }
    }

    #[test]
    fn garbage_never_panics_and_is_found_out(garbage in vec(any::<u8>(), 0..2000), tail in any_input()) {
        let mut bytes = garbage;
        bytes.push(0);
        let before = read::<TickInput>(&bytes);
        // A 32-bit check passes one bad frame in four thousand million: none here.
        prop_assert!(before.iter().all(Result::is_err));
        bytes.extend(stream(&[tail]));
        let after = read::<TickInput>(&bytes);
        prop_assert_eq!(after.len(), before.len() + 1);
        let (_, payload) = after.last().unwrap().as_ref().unwrap();
        prop_assert_eq!(bits(payload.as_ref().unwrap()), bits(&tail));
    }

    /// Garbage with a right check: the payload's own decoder must survive it too.
    #[test]
    fn a_checked_frame_of_garbage_never_panics(kind in any::<u8>(), payload in vec(any::<u8>(), 0..200)) {
        let mut frame = vec![kind, 0, 0, 0, 0];
        frame.extend(&payload);
        frame.extend(crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&frame).to_le_bytes());
        let mut stuffed = vec![0; MAX_STUFFED];
        let len = cobs::try_encode(&frame, &mut stuffed).unwrap();
        let mut decoder = Decoder::new();
        for byte in &stuffed[..len] {
            prop_assert_eq!(decoder.push(*byte), Ok(None));
        }
        match decoder.push(0) {
            Err(FrameError::Kind(unknown)) => prop_assert_eq!(unknown, kind),
            Ok(Some(frame)) => {
                let _ = frame.payload::<TickInput>();
                let _ = frame.payload::<TickRecord>();
                let _ = frame.payload::<Header>();
                let _ = frame.payload::<flight_record::Summary>();
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }
}

use super::*;
use flight_data::{Channel, to_writer};

/// Fifteen seconds with a launch and one effect.
const SHORT: &str = include_str!("../plans/short.toml");

fn bytes(text: &str, seed: u64) -> Vec<u8> {
    let scenario = Scenario::from_toml(text, "short.toml").unwrap();
    let (flight, _) = simulate(&scenario, seed).unwrap();
    let mut out = Vec::new();
    to_writer(&mut out, &flight).unwrap();
    out
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    assert_eq!(bytes(SHORT, 4), bytes(SHORT, 4));
    assert_ne!(bytes(SHORT, 4), bytes(SHORT, 5));
}

#[test]
fn one_sensors_setting_leaves_the_others_noise_alone() {
    let scenario = Scenario::from_toml(SHORT, "short.toml").unwrap();
    let mut noisier = scenario.clone();
    noisier.sensors.baro.noise.white = 9.0;
    noisier.sensors.imu_master.sampling.enabled = false;
    noisier.sensors.gps.sampling.dropout_probability = 0.3;
    let (one, _) = simulate(&scenario, 1).unwrap();
    let (two, _) = simulate(&noisier, 1).unwrap();
    let cells = |flight: &Flight, channel: Channel| -> Vec<(usize, u32)> {
        flight.channel(channel).unwrap().samples().map(|(row, value)| (row, value.to_bits())).collect()
    };
    for channel in [Channel::ImuSlaveAltM, Channel::AccelZMps2, Channel::TasMps, Channel::RollRad] {
        assert_eq!(cells(&one, channel), cells(&two, channel), "{}", channel.name());
    }
    assert_ne!(cells(&one, Channel::BaroPa), cells(&two, Channel::BaroPa));
    assert!(two.channel(Channel::ImuMasterAltM).is_none());
    // The fixes that are left are unchanged.
    let (all, left) = (cells(&one, Channel::GpsAltM), cells(&two, Channel::GpsAltM));
    assert!(left.len() < all.len() && left.iter().all(|cell| all.contains(cell)));
}

#[test]
fn every_channel_of_the_format_is_filled_at_its_rate() {
    let scenario = Scenario::from_toml(SHORT, "short.toml").unwrap();
    let (flight, truth) = simulate(&scenario, 1).unwrap();
    assert_eq!((flight.rows(), truth.rows), (3000, 3000));
    assert_eq!(truth.launch_s, Some(10.0));
    for channel in Channel::ALL {
        let samples = flight.channel(*channel).map(|column| column.samples().count());
        let expected = match channel.name() {
            // Either pressure or altitude: the simulator writes pressure.
            "baro_alt_m" => None,
            // Only a flight computer has it.
            "launch_doubt" => None,
            "launch" => Some(3000),
            name if name.starts_with("gps") => Some(75),
            name if name.starts_with("accel") || name.starts_with("gyro") => Some(3000),
            "imu_master_alt_m" => Some(500),
            _ => Some(750),
        };
        assert_eq!(samples, expected, "{}", channel.name());
    }
    let launch = flight.channel(Channel::Launch).unwrap();
    assert_eq!((launch.get(1999), launch.get(2000)), (Some(0.0), Some(1.0)));
    assert!(flight.header.source.starts_with("pylon simulate: "), "{}", flight.header.source);
}

#[test]
fn the_truth_says_what_a_calibration_should_find() {
    let text = SHORT.replace("id = \"baro", "phase = \"captive\"\nid = \"baro");
    let mut scenario = Scenario::from_toml(&text, "short.toml").unwrap();
    scenario.sensors.gps.bias_m = 3.0;
    let (_, truth) = simulate(&scenario, 1).unwrap();
    let head = truth.trajectory[..2000].iter().map(|s| s.airspeed_mps.powi(2) / 19.613_3).sum::<f64>() / 2e3;
    let baro = truth.sensors["baro"];
    assert!((baro.captive_offset_m - (20.0 + 0.05 * head - 3.0)).abs() < 1e-9, "{baro:?}");
    assert!((truth.sensors["imu_slave"].captive_offset_m + 3.0).abs() < 1e-12);
}

//! The messages that configure the receiver (u-blox F9 HPG interface description UBX-22008968, section 3.10;
//! for generation 8: receiver description UBX-13003221, section 32.10).
//! They are written out here, and the tests compare them with the `ublox` crate's builders. Those carry every
//! key of every receiver, and scale in double precision, which the flight computer does not have.

use heapless::Vec;
use kf_core::guard::Guard;

/// Longest frame that is sent.
pub(super) const FRAME_BYTES: usize = 44;
/// A frame to send.
pub(super) type Frame = Vec<u8, FRAME_BYTES>;

/// NAVSPG-DYNMODEL, CFG-NAV5: airborne, below 4 g.
const AIRBORNE_4G: u8 = 8;

/// A generation of receivers, by how it is configured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Generation {
    /// Generation 9 and later: CFG-VALSET.
    Keys,
    /// Generation 8 and earlier: one message for each subject.
    Messages,
}

impl Generation {
    pub(super) const fn other(self) -> Self {
        match self {
            Self::Keys => Self::Messages,
            Self::Messages => Self::Keys,
        }
    }
}

/// Class and id of the message at a place in a generation's sequence, and its frame; `None` after the last.
pub(super) fn message(
    generation: Generation,
    place: u8,
    period_ms: u16,
    baud: u32,
) -> Option<(u8, u8, Frame)> {
    let [low, high] = period_ms.to_le_bytes();
    let [b0, b1, b2, b3] = baud.to_le_bytes();
    // The message of generation 8 that is left out when the guard is off.
    let place = place + u8::from(generation == Generation::Messages && !Guard::UbxOnly.stands());
    let (id, payload): (u8, &[u8]) = match (generation, place) {
        (Generation::Keys, 0) => (
            0x8A,
            // Version 0, layer RAM: the settings do not survive a loss of power.
            &[
                0,
                0x01,
                0,
                0, //
                0x01,
                0x00,
                0x74,
                0x10,
                1, // CFG-UART1OUTPROT-UBX
                0x02,
                0x00,
                0x74,
                0x10,
                u8::from(!Guard::UbxOnly.stands()), // CFG-UART1OUTPROT-NMEA
                0x01,
                0x00,
                0x21,
                0x30,
                low,
                high, // CFG-RATE-MEAS, ms
                0x02,
                0x00,
                0x21,
                0x30,
                1,
                0, // CFG-RATE-NAV, a solution each measurement
                0x21,
                0x00,
                0x11,
                0x20,
                AIRBORNE_4G, // CFG-NAVSPG-DYNMODEL
                0x07,
                0x00,
                0x91,
                0x20,
                1, // CFG-MSGOUT-UBX_NAV_PVT_UART1
            ],
        ),
        // CFG-PRT, before anything that increases its output: the first UART, 8 bits, no parity, 1 stop bit,
        // its speed; input UBX, NMEA and RTCM, as by default, and output UBX.
        (Generation::Messages, 0) => {
            (0x00, &[1, 0, 0, 0, 0xC0, 0x08, 0, 0, b0, b1, b2, b3, 0x07, 0, 0x01, 0, 0, 0, 0, 0])
        }
        // CFG-MSG: NAV-PVT with every solution, on the port that receives this message.
        (Generation::Messages, 1) => (0x01, &[0x01, 0x07, 1]),
        // CFG-RATE: period, a solution each measurement, aligned to GPS time.
        (Generation::Messages, 2) => (0x08, &[low, high, 1, 0, 1, 0]),
        (Generation::Messages, 3) => {
            // CFG-NAV5: mask "dynamic model", and the model; the receiver ignores the rest.
            const NAV5: [u8; 36] = {
                let mut payload = [0; 36];
                payload[0] = 1;
                payload[2] = AIRBORNE_4G;
                payload
            };
            (0x24, &NAV5)
        }
        _ => return None,
    };
    frame(0x06, id, payload).map(|frame| (0x06, id, frame))
}

/// A UBX frame (section 3.2); `None` if it is longer than [`FRAME_BYTES`].
fn frame(class: u8, id: u8, payload: &[u8]) -> Option<Frame> {
    let mut frame = Frame::new();
    let length = u16::try_from(payload.len()).ok()?.to_le_bytes();
    frame.extend_from_slice(&[0xB5, 0x62, class, id, length[0], length[1]]).ok()?;
    frame.extend_from_slice(payload).ok()?;
    let (mut a, mut b) = (0u8, 0u8);
    for &byte in frame.iter().skip(2) {
        a = a.wrapping_add(byte);
        b = b.wrapping_add(a);
    }
    frame.extend_from_slice(&[a, b]).ok()?;
    Some(frame)
}

#[cfg(test)]
mod tests {
    use ublox::cfg_msg::CfgMsgSinglePortBuilder;
    use ublox::cfg_nav5::{CfgNav5Builder, CfgNav5Params, NavDynamicModel};
    use ublox::cfg_prt::{
        CfgPrtUartBuilder, DataBits, InProtoMask, OutProtoMask, Parity, StopBits, UartMode, UartPortId,
    };
    use ublox::cfg_rate::{AlignmentToReferenceTime, CfgRateBuilder};
    use ublox::cfg_val::CfgVal;
    use ublox::nav_pvt::proto27::NavPvt;

    use super::*;

    fn ours(generation: Generation, place: u8) -> Frame {
        message(generation, place, 100, 38_400).unwrap().2
    }

    #[test]
    fn frames_are_those_of_the_crate() {
        let mut keys = Vec::<u8, 64>::new();
        ublox::packets::cfg_val::CfgValSetBuilder {
            version: 0,
            layers: ublox::packets::cfg_val::CfgLayerSet::RAM,
            reserved1: 0,
            cfg_data: &[
                CfgVal::Uart1OutProtUbx(true),
                CfgVal::Uart1OutProtNmea(false),
                CfgVal::RateMeas(100),
                CfgVal::RateNav(1),
                CfgVal::NavSpgDynModel(NavDynamicModel::AirborneWithLess4gAcceleration),
                CfgVal::MsgOutUbxNavPvtUart1(1),
            ],
        }
        .extend_to(&mut keys);
        assert_eq!(ours(Generation::Keys, 0), keys);
        let rate =
            CfgRateBuilder { measure_rate_ms: 100, nav_rate: 1, time_ref: AlignmentToReferenceTime::Gps };
        assert_eq!(ours(Generation::Messages, 2), rate.into_packet_bytes());
        let model = CfgNav5Builder {
            mask: CfgNav5Params::DYN,
            dyn_model: NavDynamicModel::AirborneWithLess4gAcceleration,
            ..CfgNav5Builder::default()
        }
        .into_packet_bytes();
        // The crate's default fix mode is not zero; the mask makes the receiver ignore it.
        let masked = ours(Generation::Messages, 3);
        assert_eq!(masked[..9], model[..9]);
        assert_eq!(masked.len(), model.len());
        let message = CfgMsgSinglePortBuilder::set_rate_for::<NavPvt>(1);
        assert_eq!(ours(Generation::Messages, 1), message.into_packet_bytes());
        let port = CfgPrtUartBuilder {
            portid: UartPortId::Uart1,
            reserved0: 0,
            tx_ready: 0,
            mode: UartMode::new(DataBits::Eight, Parity::None, StopBits::One),
            baud_rate: 38_400,
            in_proto_mask: InProtoMask::UBLOX | InProtoMask::NMEA | InProtoMask::RTCM,
            out_proto_mask: OutProtoMask::UBLOX,
            flags: 0,
            reserved5: 0,
        };
        assert_eq!(ours(Generation::Messages, 0), port.into_packet_bytes());
    }

    #[test]
    fn every_message_fits_its_frame() {
        for (generation, messages) in [(Generation::Keys, 1), (Generation::Messages, 4)] {
            let found = (0..9).take_while(|&place| message(generation, place, 200, 9_600).is_some()).count();
            assert_eq!(found, messages, "{generation:?}");
        }
    }
}

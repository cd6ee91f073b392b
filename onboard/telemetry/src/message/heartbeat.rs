//! HEARTBEAT (0).

use kf_core::output::Phase;
use mavlink::dialects::common::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType};

/// The version that the current MAVLink messages carry.
const MAVLINK_VERSION: u8 = 3;

/// The phase of the mission.
///
/// | field | is |
/// |---|---|
/// | `custom_mode` | 0 settling, 1 calibrating, 2 free flight |
/// | `system_status` | calibrating in captive flight; active in free flight, critical once a sensor is untrustworthy |
/// | `type`, `autopilot` | an onboard controller, and no autopilot |
/// | `base_mode` | that `custom_mode` is used |
#[must_use]
pub const fn heartbeat(phase: Phase, untrustworthy: bool) -> HEARTBEAT_DATA {
    let (custom_mode, system_status) = match (phase, untrustworthy) {
        (Phase::Settling, _) => (0, MavState::MAV_STATE_CALIBRATING),
        (Phase::Calibrating, _) => (1, MavState::MAV_STATE_CALIBRATING),
        (Phase::FreeFlight, false) => (2, MavState::MAV_STATE_ACTIVE),
        (Phase::FreeFlight, true) => (2, MavState::MAV_STATE_CRITICAL),
    };
    HEARTBEAT_DATA {
        custom_mode,
        mavtype: MavType::MAV_TYPE_ONBOARD_CONTROLLER,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
        system_status,
        mavlink_version: MAVLINK_VERSION,
    }
}

"""A PX4 log as pyulog reads it, in a flight's columns.

`ulog.py LOG` writes one JSON object: each column's samples as [seconds, value], times since the
first sample of all.
"""

import json
import math
import sys

from pyulog import ULog

log = ULog(sys.argv[1])


def topic(name, instance=0):
    found = [data.data for data in log.data_list if data.name == name and data.multi_id == instance]
    return found[0] if found else None


found = {}


def put(column, data, field, factor=1.0, divisor=1.0):
    if data is None or field not in data:
        return False
    values = [(int(us), float(value) * factor / divisor) for us, value in zip(data["timestamp"], data[field])]
    values = [[us, value] for us, value in values if not math.isnan(value)]
    if values:
        found[column] = values
    return bool(values)


air = topic("vehicle_air_data")
if put("baro_pa", air, "baro_pressure_pa"):
    put("baro_temp_c", air, "baro_temp_celcius")
combined = topic("sensor_combined")
for axis, name in enumerate("xyz"):
    put(f"accel_{name}_mps2", combined, f"accelerometer_m_s2[{axis}]")
    put(f"gyro_{name}_radps", combined, f"gyro_rad[{axis}]")
attitude = topic("vehicle_attitude")
if attitude is not None:
    angles = {"roll_rad": [], "pitch_rad": [], "yaw_rad": []}
    parts = zip(attitude["timestamp"], *(attitude[f"q[{k}]"] for k in range(4)))
    for us, *quaternion in parts:
        w, x, y, z = map(float, quaternion)
        n = math.sqrt(w * w + x * x + y * y + z * z)
        w, x, y, z = w / n, x / n, y / n, z / n
        angles["roll_rad"].append([int(us), math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))])
        angles["pitch_rad"].append([int(us), math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))])
        angles["yaw_rad"].append([int(us), math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))])
    found |= angles
put("throttle", topic("actuator_controls_0"), "control[3]")
thrust = topic("vehicle_thrust_setpoint")
if "throttle" not in found and thrust is not None:
    rows = zip(thrust["timestamp"], *(thrust[f"xyz[{k}]"] for k in range(3)))
    found["throttle"] = [[int(us), math.hypot(math.hypot(float(x), float(y)), float(z))] for us, x, y, z in rows]
position = topic("vehicle_local_position")
put("autopilot_vd_mps", position, "vz")
put("autopilot_down_m", position, "z")
put("autopilot_innovation_altitude_m", topic("estimator_innovations"), "baro_vpos")
put("autopilot_innovation_altitude_m", topic("ekf2_innovations"), "vel_pos_innov[5]")

gps = topic("vehicle_gps_position")
if gps is not None:
    new = "altitude_msl_m" in gps
    fields = ["latitude_deg", "longitude_deg", "altitude_msl_m"] if new else ["lat", "lon", "alt"]
    scales = [1.0, 1.0, 1.0] if new else [1e7, 1e7, 1e3]
    names = ["latitude_deg", "longitude_deg", "gps_alt_m"]
    rest = [("gps_vn_mps", "vel_n_m_s"), ("gps_ve_mps", "vel_e_m_s"), ("gps_vd_mps", "vel_d_m_s")]
    rest += [("gps_vacc_m", "epv"), ("gps_sats", "satellites_used")]
    last = None
    for row in range(len(gps["timestamp"])):
        if gps["fix_type"][row] < 3:
            continue
        key = [gps[field][row] for field in ["time_utc_usec", *fields, "vel_n_m_s", "vel_e_m_s", "vel_d_m_s"]]
        if key[0] != 0 and key == last:
            continue
        last = key
        us = int(gps["timestamp"][row])
        for name, field, scale in zip(names, fields, scales):
            found.setdefault(name, []).append([us, float(gps[field][row]) / scale])
        for name, field in rest:
            if name.startswith("gps_v") and name != "gps_vacc_m" and not gps["vel_ned_valid"][row]:
                continue
            found.setdefault(name, []).append([us, float(gps[field][row])])

start = min((us for samples in found.values() for us, _ in samples), default=0)
print(json.dumps({name: [[(us - start) / 1e6, value] for us, value in samples] for name, samples in found.items()}))

"""An ArduPilot log as pymavlink reads it, in a flight's columns.

`dataflash.py LOG` writes one JSON object: each column's samples as [seconds, value], times since
the first sample of all.
`dataflash.py --text LOG` writes the log as text, as ArduPilot's own programs do.
"""

import json
import math
import sys

from pymavlink import DFReader


def messages(file):
    log = (DFReader.DFReader_text if file.endswith(".log") else DFReader.DFReader_binary)(file)
    while (message := log.recv_msg()) is not None:
        yield message


def as_text(file):
    log = DFReader.DFReader_binary(file)
    for layout in log.formats.values():
        print(f"FMT, {layout.type}, {layout.len}, {layout.name}, {layout.format}, {','.join(layout.columns)}")
    for message in messages(file):
        if message.get_type() != "FMT":
            values = [str(getattr(message, name)) for name in message.get_fieldnames()]
            print(", ".join([message.get_type(), *values]))


DEGREE = math.pi / 180
# Message, field, column, factor.
PLAIN = [
    ("BARO", "Press", "baro_pa", 1.0),
    ("BARO", "Temp", "baro_temp_c", 1.0),
    ("IMU", "AccX", "accel_x_mps2", 1.0),
    ("IMU", "AccY", "accel_y_mps2", 1.0),
    ("IMU", "AccZ", "accel_z_mps2", 1.0),
    ("IMU", "GyrX", "gyro_x_radps", 1.0),
    ("IMU", "GyrY", "gyro_y_radps", 1.0),
    ("IMU", "GyrZ", "gyro_z_radps", 1.0),
    ("ATT", "Roll", "roll_rad", DEGREE),
    ("ATT", "Pitch", "pitch_rad", DEGREE),
    ("CTUN", "ThrOut", "throttle", 0.01),
    ("NKF1", "VN", "autopilot_vn_mps", 1.0),
    ("NKF1", "PD", "autopilot_down_m", 1.0),
    ("NKF1", "GX", "autopilot_gyro_bias_x_radps", DEGREE),
    ("NKF3", "IVD", "autopilot_innovation_vd_mps", 1.0),
    ("NKF4", "SH", "autopilot_innovation_ratio_altitude", 1.0),
    ("RCOU", "C1", "output_1_us", 1.0),
    ("VIBE", "VibeZ", "vibration_z_mps2", 1.0),
]


def columns(file):
    found = {}
    put = lambda column, us, value: found.setdefault(column, []).append([us, value])
    fix_us = None
    for message in messages(file):
        kind = message.get_type()
        for wanted, field, column, factor in PLAIN:
            if kind == wanted and hasattr(message, field):
                put(column, message.TimeUS, getattr(message, field) * factor)
        if kind == "ATT":
            put("yaw_rad", message.TimeUS, math.remainder(message.Yaw * DEGREE, math.tau))
        if kind == "GPS" and message.Status >= 3:
            fix_us = message.TimeUS
            put("gps_alt_m", fix_us, message.Alt)
            put("gps_vn_mps", fix_us, message.Spd * math.cos(message.GCrs * DEGREE))
            put("gps_ve_mps", fix_us, message.Spd * math.sin(message.GCrs * DEGREE))
            put("gps_vd_mps", fix_us, message.VZ)
            put("gps_sats", fix_us, message.NSats)
            put("latitude_deg", fix_us, message.Lat)
            put("longitude_deg", fix_us, message.Lng)
        if kind == "GPA" and fix_us is not None:
            put("gps_vacc_m", fix_us, message.VAcc)
    return found


if sys.argv[1] == "--text":
    as_text(sys.argv[2])
else:
    found = columns(sys.argv[1])
    start_us = min(us for samples in found.values() for us, _ in samples)
    print(json.dumps({name: [[(us - start_us) / 1e6, value] for us, value in samples] for name, samples in found.items()}))

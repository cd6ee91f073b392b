"""An IGC log as aerofiles reads it, in a flight's columns.

`igc.py LOG` writes one JSON object: each column's samples as [seconds, value], times since the first fix.
Recorders write an altitude of zero for none. The format leaves the airspeed's unit to the recorder's maker,
so its numbers are not converted.
"""

import json
import sys

import aerofiles

with open(sys.argv[1], encoding="utf-8", errors="replace") as file:
    log = aerofiles.igc.Reader().read(file)
fixes = log["fix_records"][1]
found = {}


def seconds(fix):
    return fix["datetime"].timestamp()


start = seconds(fixes[0])
for column, key, only_3d in [("gps_alt_m", "gps_alt", True), ("baro_alt_m", "pressure_alt", False)]:
    samples = [
        [seconds(fix) - start, float(fix[key])]
        for fix in fixes
        if fix[key] and (fix["validity"] == "A" or not only_3d)
    ]
    if samples:
        found[column] = samples
# Satellites belong to the fix: without an altitude they are left out.
for extension, column, only_3d in [("TAS", "igc_tas", False), ("SIU", "gps_sats", True)]:
    samples = [
        [seconds(fix) - start, float(fix[extension])]
        for fix in fixes
        if fix.get(extension) is not None and (not only_3d or fix["gps_alt"] and fix["validity"] == "A")
    ]
    if samples:
        found[column] = samples
json.dump(found, sys.stdout)

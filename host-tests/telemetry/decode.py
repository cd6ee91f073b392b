"""Bytes from a telemetry line, as pymavlink decodes them.

`decode.py FILE` writes one JSON object per message: its type (`mavpackettype`), sequence number (`seq`),
sender (`system`, `component`) and fields; a number that is not finite is null. `decode.py --tlog FILE` reads
a recording as MAVProxy makes it, and adds the receiver's time (`timestamp_us`). Bytes that are no message
have the type `BAD_DATA`.
"""

import json
import math
import os
import sys

# pymavlink reads these when it is imported.
os.environ["MAVLINK20"] = "1"
os.environ["MAVLINK_DIALECT"] = "common"

from pymavlink import mavutil
from pymavlink.dialects.v20 import common


def plain(value):
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def line_of(message):
    if message.get_type() == "BAD_DATA":
        return {"mavpackettype": "BAD_DATA", "bytes": len(message.data)}
    fields = {name: plain(value) for name, value in message.to_dict().items()}
    return fields | {
        "seq": message.get_seq(),
        "system": message.get_srcSystem(),
        "component": message.get_srcComponent(),
    }


def of_line(file):
    parser = common.MAVLink(None)
    parser.robust_parsing = True
    with open(file, "rb") as stream:
        while data := stream.read(65536):
            yield from parser.parse_buffer(data) or []


def of_tlog(file):
    log = mavutil.mavlogfile(file)
    while (message := log.recv_msg()) is not None:
        yield message


def main():
    *options, file = sys.argv[1:]
    is_tlog = options == ["--tlog"]
    for message in of_tlog(file) if is_tlog else of_line(file):
        line = line_of(message)
        if is_tlog:
            line["timestamp_us"] = round(message._timestamp * 1e6)
        print(json.dumps(line))


main()

"""Writes a flight's CSV as Parquet, with the column types of other programs' tables.

`write.py FLIGHT.csv TABLE.parquet COMPRESSION PAGE_VERSION USE_DICTIONARY`
"""

import csv
import datetime
import decimal
import sys

import pyarrow
import pyarrow.parquet

flight, table, compression, page_version, use_dictionary = sys.argv[1:]
with open(flight, newline="") as file:
    rows = list(csv.DictReader(line for line in file if not line.startswith("#")))


def numbers(name, factor=1.0):
    return [float(row[name]) * factor if row[name] else None for row in rows]


def decimals(name):
    return [None if value is None else decimal.Decimal(f"{value:.6f}") for value in numbers(name)]


start = datetime.datetime(2024, 5, 1, 23, 59, tzinfo=datetime.timezone.utc)
stamps = [start + datetime.timedelta(microseconds=round(value * 1e6)) for value in numbers("time_s")]
columns = {
    "stamp": pyarrow.array(stamps, pyarrow.timestamp("us", tz="UTC")),
    "released": pyarrow.array([row["launch"] == "1" for row in rows], pyarrow.bool_()),
    "gps_altitude_m": pyarrow.array(decimals("gps_alt_m"), pyarrow.decimal128(14, 6)),
    "vn": pyarrow.array(numbers("gps_vn_mps"), pyarrow.float32()),
    "ve": pyarrow.array([None if v is None else int(v) for v in numbers("gps_ve_mps")], pyarrow.uint8()),
    "climb": pyarrow.array(numbers("gps_vd_mps", -3.6), pyarrow.float64()),
    "baro_ft": pyarrow.array(numbers("baro_alt_m", 1 / 0.3048), pyarrow.float64()),
    "ins": pyarrow.array(numbers("imu_master_alt_m"), pyarrow.float32()),
    "slave_mm": pyarrow.array([round(v * 1000) for v in numbers("imu_slave_alt_m")], pyarrow.int32()),
    "speed": pyarrow.array([None if v is None else str(v) for v in numbers("tas_mps")]).dictionary_encode(),
    "mode": pyarrow.array(["glide" if row["launch"] == "1" else "tow" for row in rows]).dictionary_encode(),
    "several": pyarrow.array([[1, 2]] * len(rows)),
    "nothing": pyarrow.array([None] * len(rows), pyarrow.float64()),
    "pair": pyarrow.array([{"a": 1.5, "b": None}] * len(rows)),
}
pyarrow.parquet.write_table(
    pyarrow.table(columns),
    table,
    compression=compression,
    data_page_version=page_version,
    use_dictionary=use_dictionary == "yes",
    row_group_size=1000,
    data_page_size=2000,
    write_page_checksum=True,
    write_page_index=page_version == "2.0",
)

"""What other programs' own readers find in a `pylon export`: column -> [rows, values present, their sum]."""

import csv
import json
import math
import sys

parquet, plain, recording = sys.argv[1:]


def told(values):
    there = [value for value in values if value is not None]
    finite = [value for value in there if math.isfinite(value)]
    return [len(values), len(there), math.fsum(finite)]


def pyarrow_reads():
    import pyarrow.parquet

    file = pyarrow.parquet.ParquetFile(parquet)
    table = file.read()
    metadata = {key.decode(): value.decode() for key, value in table.schema.metadata.items()}
    columns = {name: told(table[name].to_pylist()) for name in table.column_names}
    return {"groups": file.num_row_groups, "metadata": metadata, "columns": columns}


def duckdb_reads():
    import duckdb

    found = duckdb.sql(f"select * from read_parquet('{parquet}')")
    rows = found.fetchall()
    return {name: told([row[place] for row in rows]) for place, name in enumerate(found.columns)}


def csv_reads():
    with open(plain, newline="") as file:
        rows = list(csv.DictReader(file))
    names = list(rows[0])
    return {name: told([float(row[name]) if row[name] else None for row in rows]) for name in names}


def mcap_reads():
    from mcap.reader import make_reader

    counts = {}
    with open(recording, "rb") as file:
        for schema, _, message in make_reader(file).iter_messages():
            if schema.name == "foxglove.LocationFix":
                continue
            for name, value in json.loads(message.data).items():
                count, total = counts.get(name, (0, []))
                counts[name] = (count + 1, total + ([value] if value is not None else []))
    return {name: [count, math.fsum(values)] for name, (count, values) in counts.items()}


print(json.dumps({"pyarrow": pyarrow_reads(), "duckdb": duckdb_reads(), "csv": csv_reads(), "mcap": mcap_reads()}))

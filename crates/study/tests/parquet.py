#!/usr/bin/env python3
"""parquet.py TABLE.parquet TABLE.csv: the same numbers for pyarrow, polars and DuckDB?

Needs `pip install pyarrow polars duckdb`. Run it after a change of the Parquet writer:
    cd crates/study/tests; python3 parquet.py golden/parquet/table.parquet golden/parquet/table.csv
"""

import csv
import sys

import duckdb
import polars
import pyarrow.parquet

file, text = sys.argv[1:]
with open(text, newline="", encoding="utf-8") as lines:
    names, *rows = csv.reader(lines)


def same(value, cell):
    if value is None or isinstance(value, str):
        return (value or "") == cell
    if isinstance(value, bool):
        return str(value).lower() == cell
    return value == type(value)(cell)


def compare(reader, columns, records):
    assert columns == names, f"{reader}: {columns}"
    assert len(records) == len(rows), f"{reader}: {len(records)} rows, not {len(rows)}"
    for line, (record, row) in enumerate(zip(records, rows), 2):
        for name, value, cell in zip(names, record, row):
            assert same(value, cell), f"{reader}, line {line}, {name}: {value!r}, not {cell!r}"
    print(f"{reader}: {len(rows)} rows of {len(names)} columns are the same")


table = pyarrow.parquet.read_table(file)
compare("pyarrow", table.column_names, [list(row.values()) for row in table.to_pylist()])
table = polars.read_parquet(file)
compare("polars", table.columns, table.rows())
result = duckdb.sql(f"SELECT * FROM '{file}'")
compare("duckdb", result.columns, result.fetchall())

"""Tables in pandas, polars, pyarrow and DuckDB."""

from __future__ import annotations

import pytest


@pytest.fixture()
def frames(report):
    return report.frames


def test_pyarrow_has_units_and_definitions(frames) -> None:
    pa = pytest.importorskip("pyarrow")
    table = pa.table(frames)
    assert table.to_pydict() == frames.to_dict()
    for field in table.schema:
        assert field.metadata[b"definition"]
    assert table.schema.field("frame_time_ms").metadata[b"unit"] == b"ms"
    assert pa.schema(frames).equals(table.schema)


def test_pyarrow_takes_the_memory_itself(frames) -> None:
    pa = pytest.importorskip("pyarrow")
    places = [pa.table(frames)["frame_time_ms"].chunk(0).buffers()[1].address for _ in range(2)]
    assert places[0] == places[1]


def test_a_requested_schema_is_followed(frames) -> None:
    pa = pytest.importorskip("pyarrow")
    wanted = pa.schema([(f.name, f.type) for f in pa.schema(frames)])
    assert pa.table(frames, schema=wanted).num_rows == 3


def test_polars(frames) -> None:
    pl = pytest.importorskip("polars")
    table = pl.DataFrame(frames)
    assert table.shape == (3, len(frames.columns))
    assert table["frame_time_ms"].to_list() == frames["frame_time_ms"]
    assert table.schema["frame_cycles"] == pl.UInt64


def test_pandas(frames) -> None:
    pd = pytest.importorskip("pandas")
    table = pd.DataFrame.from_arrow(frames)
    assert list(table.columns) == frames.columns
    assert table["frame_time_ms"].tolist() == frames["frame_time_ms"]


def test_duckdb(frames) -> None:
    duckdb = pytest.importorskip("duckdb")
    sql = "select max(frame_time_ms) from frames"
    assert duckdb.sql(sql).fetchall() == [(max(frames["frame_time_ms"]),)]


def test_tables_outlive_their_owner(report) -> None:
    pa = pytest.importorskip("pyarrow")
    summary = report.summary
    expected = summary.to_dict()
    table = pa.table(summary)
    del summary
    assert table.to_pydict() == expected

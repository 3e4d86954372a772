//! The part of `docs/results.md` about sweeps, written from the columns themselves; a test keeps
//! the committed file equal to it.

use std::fmt::Write;

use super::metric::metrics;
use super::table::{FIRST, LAST};

/// The section.
pub fn results_md() -> String {
    let mut text = String::from(HEAD);
    for (name, _, definition) in FIRST {
        let _ = writeln!(text, "| `{name}` | {definition} |");
    }
    text.push_str(BETWEEN);
    for metric in metrics() {
        let _ = writeln!(text, "| `{}` | {} | {} |", metric.name, metric.unit, metric.definition);
    }
    for (name, unit, definition) in LAST {
        let _ = writeln!(text, "| `{name}` | {unit} | {definition} |");
    }
    text.push_str(QUERIES);
    text.push_str(CONFIRMED);
    text
}

const HEAD: &str = "
## Tables of sweeps

`powergs-sim sweep` writes one table, as `results.csv` and as `results.parquet`: a row for every \
design, energy table and trace, and two aggregates over the traces. Designs are in the order \
of the space, the baseline first; designs that a constraint leaves out have no row. A design that \
failed has rows without numbers and is part of no aggregate.

| column | definition |
|---|---|
";

const BETWEEN: &str = "
Then comes a column for every axis and derived key of the sweep, named by its key (`vru.cores`) \
and written as in a file; behind a measure (`64 KiB`) a column with the ending `.si` has the \
same in bytes, hertz, seconds, joules or watts. Then the metrics. In `trace` rows they are over \
the frames of the trace; in `mean` rows means are weighted by the traces' weights, and quantiles \
are over all frames of all traces, every frame with its share of the weight of its trace.

| column | unit | definition |
|---|---|---|
";

const QUERIES: &str = "
Three queries that were run on such a file:

```sql
-- DuckDB: the five designs with the least power that reach 60 FPS in their slowest frame
SELECT point, id, \"fps.min\", \"power_w.mean\", area_mm2 FROM 'results.parquet'
WHERE scope = 'mean' AND status = 'ok' AND \"fps.min\" >= 60
ORDER BY \"power_w.mean\" LIMIT 5;
```

```python
# pandas: what doubling the cores does, all else equal
import pandas as pd
# `numpy_nullable`: whole numbers with gaps, as `point` has at the baseline, stay whole
t = pd.read_parquet(\"results.parquet\", dtype_backend=\"numpy_nullable\")
t = t.query(\"scope == 'mean' and status == 'ok'\")
print(t.groupby(\"vru.cores\")[[\"fps.mean\", \"power_w.mean\", \"area_mm2\"]].median())
```

```python
# polars: designs that are faster and smaller than the baseline
import polars as pl
t = pl.read_parquet(\"results.parquet\").filter(pl.col(\"scope\") == \"mean\")
base = t.filter(pl.col(\"is_baseline\")).row(0, named=True)
better = (pl.col(\"fps.mean\") > base[\"fps.mean\"]) & (pl.col(\"area_mm2\") < base[\"area_mm2\"])
print(t.filter(better).select(\"id\", \"fps.mean\", \"area_mm2\").sort(\"area_mm2\"))
```
";

const CONFIRMED: &str = "
`confirmed.csv` compares designs of the front with the `calibrated` and the `banked` model of the \
DRAM ([analysis.md](analysis.md#the-front-confirmed)): a row for every design and compared column, \
the knee first.

| column | definition |
|---|---|
| `point`, `id` | the design, as in `results.csv` |
| `role` | `knee` or `front`: what it is in the sweep |
| `standing` | with `banked`, among the confirmed designs: `front`, `beaten` by another, `late` \
(misses the display rate), `unmet` (the condition), `failed` |
| `column` | a column of `results.csv`: frame time, rate, energy, power, area, and the objectives |
| `calibrated`, `banked` | its value with either model, in the unit of the column |
| `difference_frac` | (calibrated - banked) / banked |
";

//! The sweeps that come with the program, at small size.

use predicates::str::contains;

use super::Bench;

#[test]
fn every_example_answers_its_question() {
    let bench = Bench::new();
    for name in ["gscore-units", "sram-bandwidth", "tiles", "node-energy"] {
        let run = ["sweep", name, "--traces", "demo.bin", "--points", "10", "--out", name];
        bench.program(&run).assert().success().stdout(contains("?"));
        assert!(bench.path(name).join("analysis/report.html").exists(), "{name}");
        assert!(bench.path(name).join("analysis/front.png").exists(), "{name}");
    }
    let where_ = "frame_time_ms.p99 <= 16.67 && area_mm2 <= 4";
    let objectives = ["--minimize", "power_w.mean,area_mm2", "--maximize", "fps.mean"];
    let pareto = ["pareto", "gscore-units", "--where", where_];
    bench.program(&pareto).args(objectives).assert().success().stdout(contains("knee"));
}

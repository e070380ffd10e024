//! The number of threads changes how long a command takes and nothing else.

use std::fs;

use crate::workbench::Workbench;

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let bench = Workbench::new();
    bench.write(
        "scene.toml",
        "[motion]\nframes = 4\nkeyframes = [{ at = 3, depth_mm = 0.4 }]\n[render]\nwidth = 160\nheight = 160",
    );
    let files = |threads: u32| {
        bench
            .run(&format!("simulate scene.toml --out truth --draft --no-cache --overwrite --threads {threads}"))
            .expect_done();
        bench
            .run(&format!("--threads {threads} track truth/frames --out run --overwrite --profile truth/profile.toml"))
            .expect_done();
        let names = [
            "truth/truth/flow.npy",
            "truth/truth/depth.npy",
            "truth/truth/force.csv",
            "truth/frames/000003.png",
            "run/flow.npy",
            "run/depth.npy",
            "run/contact.npy",
        ];
        names.map(|name| fs::read(bench.path(name)).unwrap())
    };
    assert!(files(1) == files(3), "one thread and three differ");
}

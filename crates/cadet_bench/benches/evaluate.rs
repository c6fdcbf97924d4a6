//! KITTI's AP of a validation set's size: 3,769 frames with about 49,000 detections, three classes, six metrics, three
//! levels. `from_files` reads 7,538 files first. KITTI's own program takes 17.9 s for such a set.

use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};

use cadet_core::Result;
use cadet_core::evaluate::{FramePair, Parsed, evaluate, parse_detections, parse_truths, read_files};
use criterion::{Criterion, criterion_group, criterion_main};

#[path = "../../cadet_core/tests/evaluation/frames.rs"]
mod frames;

const NUM_FRAMES: usize = 3769;

/// A folder that goes when the benchmark does.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left behind lies in the system's folder for such things.
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn written(frames: &[FramePair]) -> std::io::Result<Folder> {
    let folder = Folder(std::env::temp_dir().join(format!("cadet-bench-{}", std::process::id())));
    for (name, text) in [("label_2", frames::label_text as fn(&FramePair) -> String), ("det", frames::result_text)] {
        fs::create_dir_all(folder.0.join(name))?;
        for (index, frame) in frames.iter().enumerate() {
            fs::write(folder.0.join(name).join(format!("{index:06}.txt")), text(frame))?;
        }
    }
    Ok(folder)
}

fn read(folder: &Path, ids: &[Option<String>]) -> Result<Vec<FramePair>> {
    let truths = read_files(&folder.join("label_2"), ids, parse_truths)?;
    let parsed = read_files(&folder.join("det"), ids, parse_detections)?;
    let pair = |(truths, detections): (Parsed<_>, Parsed<_>)| FramePair {
        truths: truths.objects,
        detections: detections.objects,
    };
    Ok(truths.into_iter().zip(parsed).map(pair).collect())
}

fn bench(criterion: &mut Criterion) {
    let (frames, settings) = (frames::draw(0, NUM_FRAMES), frames::kitti());
    let folder = written(&frames).expect("a writable temporary folder");
    let ids: Vec<Option<String>> = (0..NUM_FRAMES).map(|index| Some(format!("{index:06}"))).collect();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut group = criterion.benchmark_group("evaluate");
    group.sample_size(20);
    let from_files = || {
        let frames = read(&folder.0, &ids).expect("well-formed files");
        evaluate(&frames, &settings).expect("settings that make sense")
    };
    group.bench_function("from_files", |bencher| bencher.iter(from_files));
    group.bench_function("from_files/one_thread", |bencher| bencher.iter(|| one.install(from_files)));
    let in_memory = || evaluate(black_box(&frames), &settings).expect("settings that make sense");
    group.bench_function("in_memory", |bencher| bencher.iter(in_memory));
    group.bench_function("in_memory/one_thread", |bencher| bencher.iter(|| one.install(in_memory)));
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);

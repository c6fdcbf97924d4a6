//! What an image of a suburb costs at least: on a shared machine means follow the neighbors, the least of many runs hardly.
//!
//! `cargo bench -p cadet_bench --bench image_least -- 40` takes each image 40 times; the number may be left out. A weather's name
//! after it is that of all images.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod suburbs;

use std::hint::black_box;
use std::time::Instant;

use cadet_core::camera::{render, visibility_pass};
use cadet_core::rng::StreamKey;
use cadet_core::weather::Weather;

use suburbs::{VIEWS, place, suburb};

/// Milliseconds since an instant.
fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

fn main() {
    let runs: usize = std::env::args().find_map(|arg| arg.parse().ok()).unwrap_or(40).max(1);
    println!("1242 x 375, one thread, milliseconds: the least of {runs} runs, and the median of the whole");
    println!("suburb  weather          pass  shade  whole  median");
    let mut sums = [0.0; 2];
    let everywhere = std::env::args().find(|arg| Weather::preset(arg).is_ok());
    for (seed, weather) in VIEWS {
        let weather = everywhere.as_deref().unwrap_or(weather);
        let mut scene = suburb(seed, weather);
        scene.step(0.1).expect("drives");
        let (posed, view) = place(&mut scene);
        let mut stream = StreamKey::scene(seed).indexed("camera", 0);
        let mut times: Vec<[f64; 2]> = Vec::new();
        for _ in 0..runs {
            let start = Instant::now();
            let seen = visibility_pass(&posed, &view).expect("looks");
            let look_ms = ms_since(start);
            black_box(render(&posed, &view, scene.weather(), &seen, &mut stream));
            times.push([look_ms, ms_since(start)]);
        }
        let least = |of: fn(&[f64; 2]) -> f64| times.iter().map(of).fold(f64::INFINITY, f64::min);
        let (look_ms, paint_ms, whole_ms) = (least(|t| t[0]), least(|t| t[1] - t[0]), least(|t| t[1]));
        times.sort_unstable_by(|a, b| a[1].total_cmp(&b[1]));
        let median_ms = times[runs / 2][1];
        println!("{seed:6}  {weather:14}  {look_ms:5.1}  {paint_ms:5.1}  {whole_ms:5.1}  {median_ms:6.1}");
        sums = [sums[0] + whole_ms, sums[1] + median_ms];
    }
    let [whole_ms, median_ms] = sums.map(|sum| sum / VIEWS.len() as f64);
    println!("mean                                {whole_ms:5.1}  {median_ms:6.1}");
}

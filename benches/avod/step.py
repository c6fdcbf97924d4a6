"""A full-size training step and detection in float32 and in bfloat16: `python benches/avod/step.py DATA [--threads 2]`.

DATA is a KITTI folder, for example 20 frames of `cadet-gen`. The variants take turns on the same frames, from the
device's memory, so that what else the machine does weighs on all alike; medians of processor time, or on a GPU of wall
time. Compiling is not counted.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import torch

from avod.cli.process import set_up_process
from avod.config import Config
from avod.data.dataset import TrainingData
from avod.data.sample import Sample
from avod.device import resolve_device
from avod.model.network import AnyNetwork
from avod.train.step import make_optimizer, new_network, training_step


def has_amx() -> bool:
    """Say whether the processor multiplies matrices of bfloat16 in tiles."""
    try:
        return "amx_bf16" in Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")
    except OSError:
        return False


def seconds(function: Callable[[], object], device: torch.device) -> float:
    """Time a call, with all that it lets the device do."""
    clock = time.process_time if device.type == "cpu" else time.perf_counter
    start = clock()
    function()
    if device.type == "cuda":
        torch.cuda.synchronize(device)
    return clock() - start


def main() -> None:
    """Print the medians and their ratios."""
    parser = argparse.ArgumentParser(description="Time avod's training step and network.")
    parser.add_argument("data", type=Path)
    parser.add_argument("--config", default="car_default")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--frames-per-step", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--compile", action="store_true", help="a third variant: bfloat16 with compiled pyramids")
    args = parser.parse_args()
    set_up_process()
    torch.set_num_threads(args.threads)
    config, device = Config.named(args.config), resolve_device(args.device)
    data = TrainingData(args.data, None, config, 0)
    count = args.frames_per_step
    frames = [
        sample.to(device)
        for sample in (data[i] for i in range((args.rounds + 1) * count))
        if isinstance(sample, Sample)
    ]
    variants: dict[str, AnyNetwork] = {}
    for name in ["float32", "bf16", *(["bf16, compiled"] if args.compile else [])]:
        network = variants[name] = new_network(config, 0).to(device)
        network.precision = None if name == "float32" else torch.bfloat16
        if name.endswith("compiled"):
            for extractor in network.extractors():
                extractor.compile(dynamic=False)
    optimizers = {name: make_optimizer(network.train(), config.training) for name, network in variants.items()}
    step_s: dict[str, list[float]] = {name: [] for name in variants}
    detect_s: dict[str, list[float]] = {name: [] for name in variants}
    for step in range(args.rounds + 1):
        samples = frames[step * count : (step + 1) * count]
        for name, network in variants.items():
            train = partial(training_step, network.train(), optimizers[name], samples, config, step=step, seed=0)
            step_s[name].append(seconds(train, device))
            with torch.inference_mode():
                detect_s[name].append(seconds(partial(network.eval(), samples[:1]), device))
    machine = f"{args.threads} threads, AMX: {'yes' if has_amx() else 'no'}"
    if device.type == "cuda":
        machine = f"{torch.cuda.get_device_name(device)}, {torch.cuda.max_memory_allocated(device) / 2**30:.1f} GiB"
    print(f"{args.config}, {count} frames a step, torch {torch.__version__}, {machine}")
    print("variant            step, s   times float32   network in detection of a frame, s")
    for name in variants:
        # The first round warms up and compiles.
        median, detection = float(np.median(step_s[name][1:])), float(np.median(detect_s[name][1:]))
        ratio = float(np.median(step_s["float32"][1:])) / median
        print(f"{name:18s} {median:7.3f} {ratio:15.2f} {detection:36.3f}")


if __name__ == "__main__":
    main()

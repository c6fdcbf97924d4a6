"""A full-size training step and detection in float32 and in bfloat16: `python benches/avod/step.py DATA [--threads 2]`.

DATA is a KITTI folder, for example 20 frames of `cadet-gen`. The variants take turns on the same frames, so that what
else the machine does weighs on all alike; medians of wall time. Compiling is not counted.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
import torch

from avod.config_file import load_config
from avod.data.dataset import TrainingData
from avod.data.sample import Sample
from avod.model.network import AvodNetwork
from avod.train.step import make_optimizer, new_network, training_step


def has_amx() -> bool:
    """Say whether the processor multiplies matrices of bfloat16 in tiles."""
    try:
        return "amx_bf16" in Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")
    except OSError:
        return False


def main() -> None:
    """Print the medians and their ratios."""
    parser = argparse.ArgumentParser(description="Time avod's training step and network on a CPU.")
    parser.add_argument("data", type=Path)
    parser.add_argument("--config", default="car_default")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--compile", action="store_true", help="a third variant: bfloat16 with compiled pyramids")
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    config = load_config(args.config)
    data = TrainingData(args.data, None, config, 0)
    samples = [sample for sample in (data[i] for i in range(args.rounds + 1)) if isinstance(sample, Sample)]
    variants: dict[str, AvodNetwork] = {}
    for name in ["float32", "bf16", *(["bf16, compiled"] if args.compile else [])]:
        network = variants[name] = new_network(config, 0)
        network.precision = None if name == "float32" else torch.bfloat16
        if name.endswith("compiled"):
            for pyramid in (network.bev_pyramid, network.image_pyramid):
                pyramid.compile(dynamic=False)
    optimizers = {name: make_optimizer(network.train(), config.training) for name, network in variants.items()}
    step_s: dict[str, list[float]] = {name: [] for name in variants}
    detect_s: dict[str, list[float]] = {name: [] for name in variants}
    for step, sample in enumerate(samples):
        for name, network in variants.items():
            start = time.perf_counter()
            training_step(network.train(), optimizers[name], [sample], config, step=step, seed=0)
            step_s[name].append(time.perf_counter() - start)
            with torch.inference_mode():
                network.eval()
                start = time.perf_counter()
                network([sample])
                detect_s[name].append(time.perf_counter() - start)
    print(f"{args.config}, {args.threads} threads, torch {torch.__version__}, AMX: {'yes' if has_amx() else 'no'}")
    print("variant            step, s   times float32   network in detection, s")
    for name in variants:
        # The first round warms up and compiles.
        median, detection = float(np.median(step_s[name][1:])), float(np.median(detect_s[name][1:]))
        ratio = float(np.median(step_s["float32"][1:])) / median
        print(f"{name:18s} {median:7.2f} {ratio:15.2f} {detection:25.2f}")


if __name__ == "__main__":
    main()

#!/usr/bin/env bash
# Make frames, train AVOD-FPN on them on a GPU for some minutes, and measure it: speed, AP, inference.
#
#   REAL=kitti OUT=results benches/gpu/run.sh
#   make bench-gpu        # the same on a CPU, with eight frames and a small network, to try the script
#
# Needs the commands cadet-gen, cadet, and avod, and their python3 (pip install 'cadet-sim[avod]'). Each step writes its
# results into OUT at once: report.md, run.log, the training's log.csv, and the weights as halves. Frames and checkpoints
# are in WORK; the same command goes on from there with what is missing.
set -euo pipefail

OUT=${OUT:-gpu_results}
WORK=${WORK:-gpu_work}             # frames take 3 MB each
FRAMES=${FRAMES:-4000}             # to learn from
HELD_OUT=${HELD_OUT:-200}          # other streets, to be judged by
REAL=${REAL:-}                     # a KITTI folder with labels, to be judged by too
GEN_SECONDS=${GEN_SECONDS:-3600}   # the longest that making the frames to learn from may take
MINUTES=${MINUTES:-7}              # the longest that training may take
STEPS=${STEPS:-}                   # of training; by default what fits into the minutes, by the time of ...
TRIAL_STEPS=${TRIAL_STEPS:-60}     # ... so many
CONFIG=${CONFIG:-car_default}
BATCH=${BATCH:-2}                  # frames a step
RATE=${RATE:-4e-4}                 # the first learning rate
DEVICE=${DEVICE:-cuda}
PRECISION=${PRECISION-bfloat16}        # empty: float32
COMPILE=${COMPILE-1}               # empty: do not compile the pyramids
PYTHON=${PYTHON:-python3}

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
arithmetic=(--device "$DEVICE" ${PRECISION:+--precision "$PRECISION"})
mkdir -p "$OUT" "$WORK"
exec > >(tee -a "$OUT/run.log") 2>&1
ulimit -Sn "$(ulimit -Hn)"         # the samples that workers hand over are open files

once() { # STEP ARGUMENTS...
    if [ -e "$WORK/$1${2:+_$2}.done" ]; then return; fi
    echo "== $*"
    start=$EPOCHREALTIME
    "$@"
    touch "$WORK/$1${2:+_$2}.done"
}

seconds() { awk "BEGIN { printf \"%.1f\", $EPOCHREALTIME - $start }"; }

report() { echo "$*" | tee -a "$OUT/report.md"; }

machine() {
    report "$(cadet --version), $CONFIG, $BATCH frames a step, ${PRECISION:-float32}, on $("$PYTHON" -c '
import os, sys, platform, torch
is_gpu = sys.argv[1].startswith("cuda")
print(torch.cuda.get_device_name(sys.argv[1]) if is_gpu else platform.machine(), end=", ")
print(len(os.sched_getaffinity(0)), "processors, torch", torch.__version__)' "$DEVICE")"
}

frames() { # NAME COUNT SEED
    local resume=()
    if [ -e "$WORK/$1/run.json" ]; then resume=(--resume); fi
    timeout -k 30 "$GEN_SECONDS" cadet-gen "$WORK/$1" -n "$2" --seed "$3" "${resume[@]}" || [ $? -eq 124 ]
    local made=("$WORK/$1"/training/velodyne/*.bin)
    report "- $1: ${#made[@]} frames in $(seconds) s"
}

write_config() { # STEPS FILE
    cat > "$2" << END
base = "$CONFIG"
# Real frames have no plane files.
ground = "estimated"

# What so few steps need: quicker averages, and copies of true boxes until the first stage has learned.
[extractor]
batch_norm_decay = 0.99

[second_stage]
truth_proposals = 8
truth_steps = $(($1 / 2))

[training]
steps = $1
frames_per_step = $BATCH
learning_rate = $RATE
decay_factor = 0.5
decay_steps = $(($1 / 6 + 1))
checkpoint_steps = $(($1 / 4 + 1))
END
}

train() { # NAME MORE...
    avod train --config "$WORK/$1.toml" --data "$WORK/set" --split all --out "$WORK/$1" --keep 1 \
        "${arithmetic[@]}" ${COMPILE:+--compile} "${@:2}"
}

trial() {
    write_config "$TRIAL_STEPS" "$WORK/trial.toml"
    rm -rf "$WORK/trial"
    train trial
    # The last row's seconds a step: those before compiled.
    STEPS=$(awk -F , -v minutes="$MINUTES" 'END { printf "%d", 1 + 0.9 * 60 * minutes / $NF }' "$WORK/trial/log.csv")
}

schedule() {
    if [ -z "$STEPS" ]; then trial; fi
    write_config "$STEPS" "$WORK/run.toml"
}

training() {
    local resume=()
    if [ -e "$WORK/run/run.json" ]; then resume=(--resume); fi
    # 75: the minutes are over.
    train run --max-minutes "$MINUTES" "${resume[@]}" || [ $? -eq 75 ]
    cp "$WORK/run/log.csv" "$OUT/"
    local steps=("$WORK"/run/checkpoints/*)
    report "- training: $((10#${steps[-1]##*/})) steps in $(seconds) s, $(awk -F , 'NR > 1 { print 1e3 * $NF }' "$OUT/log.csv" |
        sort -n | awk '{ row[NR] = $1 } END { print row[int((NR + 1) / 2)] }') ms a step (median)"
}

weights() {
    "$PYTHON" "$here/weights.py" split "$WORK/run" "$OUT/weights"
    # What is judged from here on is what others get.
    "$PYTHON" "$here/weights.py" join "$OUT/weights" "$WORK/joined"
}

ap() { # NAME FOLDER
    avod predict --checkpoint "$WORK/joined" --data "$2" --split all --out "$WORK/found_$1" "${arithmetic[@]}"
    for limits in strict loose; do
        report "
AP on the $1 frames, $limits limits"
        report "$(cadet eval "$2" "$WORK/found_$1" --classes Car --min-overlap "$limits" --bootstrap 300 --markdown)"
    done
}

inference() { # ARITHMETIC MORE...
    report "
Inference, $1
$(avod bench --checkpoint "$WORK/joined" --data "${REAL:-$WORK/held_out}" --device "$DEVICE" "${@:2}")"
}

once machine
once frames set "$FRAMES" 100
once frames held_out "$HELD_OUT" 7
once schedule
once training
once weights
if [ -n "$REAL" ]; then once ap real "$REAL"; fi
once ap held_out "$WORK/held_out"
once inference float32
once inference bf16 --precision bfloat16

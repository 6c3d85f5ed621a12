#!/usr/bin/env bash
# Measures the GPU of this machine once, and writes one folder to send back:
#
#   benches/on_a_gpu.sh [FOLDER]        default: target/on-a-gpu of the repository
#
# About five minutes. First all engines must return the same bits. Then the times of single decisions and of batches are
# measured, and the power where the vendor's tool is installed. Without a hardware GPU the software adapters are measured.
#
# Exit status: 0 all was measured; 1 the engines differ, an adapter does not open, or a GPU is lost; 2 a command fails.
set -euo pipefail
repository=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "${1:-$repository/target/on-a-gpu}"
folder=$(cd "${1:-$repository/target/on-a-gpu}" && pwd)
cd "$repository"

cargo build --release --locked --bin inbye
inbye=target/release/inbye

$inbye --version >"$folder/version.txt"
git rev-parse HEAD >>"$folder/version.txt" 2>/dev/null || true
$inbye devices --json >"$folder/devices.json"
$inbye doctor --json >"$folder/doctor.json" || true

echo "on_a_gpu: comparing the bits of all engines" >&2
status=0
$inbye verify --cases 500 --json >"$folder/verify.json" || status=$?
if [ "$status" -ne 0 ]; then
    if grep -q '"agree":false' "$folder/verify.json"; then
        reason="the engines differ"
    elif [ "$status" -eq 1 ]; then
        reason="an adapter does not open, see the warning above"
    else
        reason="an engine failed, see the error above"
    fi
    echo "on_a_gpu: $reason. Please send $folder: nothing else is measured." >&2
    exit "$status"
fi

# A line every 200 ms, while the rest runs.
sampler=
if command -v nvidia-smi >/dev/null; then
    nvidia-smi --query-gpu=timestamp,name,power.draw,clocks.sm,utilization.gpu --format=csv -lms 200 >"$folder/power.csv" &
    sampler=$!
elif command -v tegrastats >/dev/null; then
    tegrastats --interval 200 >"$folder/power.txt" &
    sampler=$!
elif command -v amd-smi >/dev/null; then
    amd-smi metric --power --clock --usage --csv --watch 1 >"$folder/power.csv" &
    sampler=$!
fi
if [ -n "$sampler" ]; then
    trap 'kill "$sampler" 2>/dev/null || true' EXIT
fi

echo "on_a_gpu: measuring decisions and batches" >&2
$inbye bench density --ticks 0 --missions 0 --record "$folder/density.csv" --json >"$folder/density.json" || status=$?
if [ "$status" -ne 0 ]; then
    echo "on_a_gpu: the measurement is not complete, see the messages above. Please send $folder all the same." >&2
    exit "$status"
fi

echo "on_a_gpu: done. Please send the folder $folder in an issue, with the name of the machine." >&2

#!/usr/bin/env bash
# What NVIDIA's compiler makes of the shaders, on a machine without a GPU:
#
#   benches/nvidia_statistics.sh > benches/records/shader-statistics-nvidia.csv
#
# WGSL becomes HLSL (naga), CUDA C++ (Slang), PTX (NVRTC) and machine code (ptxas). NVIDIA's Vulkan driver has another front
# end, so its code is close to this but not equal. Needs Rust, Python 3 with venv, and about 1 GB below target/nvidia.
set -euo pipefail
cd "$(dirname "$0")/.."
out=target/nvidia
mkdir -p "$out"

if [ ! -x "$out/bin/naga" ]; then
    cargo install --quiet --locked naga-cli --version '^30' --root "$out" >&2
fi
if [ ! -x "$out/python/bin/python" ]; then
    python3 -m venv "$out/python"
    "$out/python/bin/pip" install --quiet --no-deps nvidia-cuda-nvcc-cu12==12.9.86 nvidia-cuda-nvrtc-cu12 \
        nvidia-cuda-runtime-cu12 nvidia-cuda-nvdisasm slangtorch >&2
fi
packages=$(echo "$PWD/$out"/python/lib/python3*/site-packages)
mkdir -p "$out/lib"
ln -sf "$packages/nvidia/cuda_nvrtc/lib/libnvrtc.so.12" "$out/lib/libnvrtc.so"
export LD_LIBRARY_PATH="$PWD/$out/lib:$packages/nvidia/cuda_nvrtc/lib:$packages/slangtorch/bin"
slang=$packages/slangtorch/bin/slangc

# The order of src/local/gpu/pipelines.rs.
for part in numeric layout rollout score select batch tabulate evaluate decide; do
    cat "shaders/$part.wgsl"
    echo
done >"$out/all.wgsl"

# Slang copies the words of buffers byte by byte. They are aligned: copy them whole.
whole_words() {
    sed -i -E \
        -e 's/memcpy\(&data, \(\(const char\*\)this->data\) \+ index, sizeof\(T\)\);/data = *(const T*)((const char*)this->data + index);/' \
        -e 's/memcpy\(\(char\*\)data \+ index, &value, sizeof\(T\)\);/*(T*)((char*)data + index) = value;/' "$1"
}

# NAME ENTRY_POINT OVERRIDES...
compile() {
    local name=$1 entry=$2
    shift 2
    local file=$out/$name
    "$out/bin/naga" "$out/all.wgsl" "$file.hlsl" --entry-point "$entry" --shader-model 60 "$@" >&2
    local emitted
    emitted=$(grep -oE "void ${entry}_?\(" "$file.hlsl" | tr -d '(' | cut -c6-)
    "$slang" "$file.hlsl" -lang hlsl -entry "$emitted" -stage compute -target cuda -o "$file.cu" 2>"$file.log"
    whole_words "$file.cu"
    "$slang" "$file.cu" -lang cuda -pass-through nvrtc -entry "$emitted" -stage compute -capability cuda_sm_8_0 -target ptx \
        -O3 -o "$file.ptx" -Xnvrtc -I"$packages/nvidia/cuda_runtime/include" 2>"$file.log"
    for model in sm_87 sm_90; do
        local report
        report=$("$packages/nvidia/cuda_nvcc/bin/ptxas" -v -O3 "-arch=$model" -o "$file.$model.cubin" "$file.ptx" 2>&1)
        "$packages/nvidia/cu13/bin/nvdisasm" -c "$file.$model.cubin" >"$file.$model.sass"
        python3 - "$name" "$model" "$file.$model.sass" "$report" <<'PYTHON'
import re, sys

name, model, path, report = sys.argv[1:]
instructions, labels = [], {}
for line in open(path):
    if label := re.match(r"\s*(\.L_x_\d+):", line):
        labels[label[1]] = len(instructions)
    elif code := re.match(r"\s*/\*[0-9a-f]+\*/\s+(?:@!?U?P\w+\s+)?([A-Z][A-Z0-9_.]*)(.*);", line):
        instructions.append((code[1], code[2]))
# The largest loop with a global load and a branch out; in the evaluation that is the loop over the steps.
largest = 0
for end, (operation, operands) in enumerate(instructions):
    target = re.search(r"(\.L_x_\d+)", operands)
    start = labels.get(target[1], len(instructions)) if operation.startswith("BRA") and target else len(instructions)
    body = instructions[start : end + 1]
    loads = sum(one.startswith("LDG") for one, _ in body)
    branches = sum(one.startswith("BRA") for one, _ in body)
    if loads and branches > 2:
        largest = max(largest, len(body))
number = lambda pattern: int((re.search(pattern, report) or [0, 0])[1])
print(name, model, number(r"Used (\d+) registers"), number(r"(\d+) bytes spill stores"), number(r"(\d+) bytes stack frame"),
      number(r"(\d+) bytes smem"), len(instructions), largest, sep=",")
PYTHON
    done
}

echo "pipeline,model,registers,spilled_bytes,stack_bytes,workgroup_bytes,instructions,largest_loop_instructions"
compile tabulate_profiles tabulate_profiles
compile evaluate_samples evaluate_samples
compile evaluate_one_static_disc evaluate_samples --override ONE_DISC=1 --override MOVING_OBSTACLES=0
compile decide decide
compile normalize normalize
compile score_samples score_samples
compile select_winner select_winner

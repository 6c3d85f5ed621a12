#!/usr/bin/env bash
# Tests the CPU engine of aarch64 under emulation, and counts the instructions of a decision:
#
#   benches/aarch64.sh > benches/records/lane-instructions-aarch64.csv
#
# Needs what packaging/aarch64 needs, and awk.
set -euo pipefail
cd "$(dirname "$0")/.."
target=aarch64-unknown-linux-gnu
emulator=(qemu-aarch64 -L /usr/aarch64-linux-gnu)
run() {
    packaging/aarch64 env CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
        CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="${emulator[*]}" "$@"
}
with=(--locked --target "$target" --no-default-features --features gpu,experiment)
run cargo test --release "${with[@]}" --lib local:: >&2
run cargo test --release "${with[@]}" --test engine -- lanes instruction_set >&2
run cargo bench "${with[@]}" --bench lane_instructions --no-run >&2
root=target/aarch64
program=$(cd "$root" && find "built/$target/release/deps" -name 'lane_instructions-*' -executable -type f -printf '%T@ /%p\n' |
    sort -n | tail -1 | cut -d' ' -f2)

# Instructions of a run: those of each block of code, as often as it ran. Debian builds the emulator without plugins.
rm -f "$root/tmp/blocks"
mkfifo "$root/tmp/blocks"
count() {
    awk '
        /^IN:/ { first = ""; inside = 1; next }
        inside && /^0x/ { at = substr($1, 3, length($1) - 3); if (first == "") { first = at; size[at] = 0 } size[first]++; next }
        inside && /^$/ { inside = 0 }
        /^Trace/ { split($4, word, "/"); sub(/^0+/, "", word[2]); total += size[word[2]] }
        END { printf "%d\n", total }' "$root/tmp/blocks" &
    run "${emulator[@]}" -d in_asm,exec,nochain -D /tmp/blocks "$program" "$@" >/dev/null
    wait
}
echo "sampler,samples,steps,window_s,portable,neon,share"
while read -r sampler samples steps window_s; do
    for lanes in portable NEON; do
        twice=$(count $lanes $sampler $samples $steps $window_s 2)
        four_times=$(count $lanes $sampler $samples $steps $window_s 4)
        echo $(((four_times - twice) / 2))
    done | xargs | awk -v what="$sampler,$samples,$steps,$window_s" '{ printf "%s,%d,%d,%.3f\n", what, $1, $2, $2 / $1 }'
done <<END
arcs 1024 30 0.1
arcs 1024 30 1.0
arcs 4096 30 0.1
arcs 4096 30 1.0
arcs 16384 40 0.1
arcs 16384 40 1.0
ramps 4096 20 0.1
ramps 4096 20 1.0
two_segments 4096 20 0.1
two_segments 4096 20 1.0
sequences 4096 20 0.1
sequences 4096 20 1.0
END

#!/usr/bin/env bash
# Tests the CPU engine of aarch64 under emulation, and counts the instructions of a decision:
#
#   benches/aarch64.sh > benches/records/lane-instructions-aarch64.csv
#
# rustup's target for aarch64 is not needed: the compiler, its library and the emulator are those of Debian's unstable release,
# in a folder of their own (target/aarch64, 4 GB with what is built). Needs Linux on x86-64, root, debootstrap and awk.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD/target/aarch64
target=aarch64-unknown-linux-gnu

if [ ! -e "$root/ready" ]; then
    debootstrap --variant=minbase --include=ca-certificates sid "$root" >&2
    # A mirror may be older than its own dates permit.
    echo 'Acquire::Check-Valid-Until "false";' >"$root/etc/apt/apt.conf.d/mirror"
    chroot "$root" dpkg --add-architecture arm64
    chroot "$root" apt-get update -qq >&2
    chroot "$root" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends cargo rustc gcc libc6-dev \
        gcc-aarch64-linux-gnu libc6-dev-arm64-cross libstd-rust-dev:arm64 qemu-user >&2
    mkdir -p "$root/inbye" "$root/cargo"
    touch "$root/ready"
fi

cargo fetch --quiet --locked
# The mounts end with this shell.
export root target
exec unshare --mount bash -euo pipefail -c '
mount --bind . "$root/inbye"
mount --bind "${CARGO_HOME:-$HOME/.cargo}" "$root/cargo"
mount --bind /dev "$root/dev"
mount -t proc proc "$root/proc"
run() {
    chroot "$root" env -i PATH=/usr/bin:/bin HOME=/root CARGO_HOME=/cargo CARGO_TARGET_DIR=/built \
        CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
        CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu" \
        sh -c "cd /inbye && $*"
}
with="--release --offline --locked --target $target --no-default-features --features gpu,experiment"
run cargo test $with --lib local:: >&2
run cargo test $with --test engine -- lanes instruction_set >&2
run cargo bench ${with#--release} --bench lane_instructions --no-run >&2
program=$(cd "$root" && find built/$target/release/deps -name "lane_instructions-*" -executable -type f -printf "%T@ /%p\n" |
    sort -n | tail -1 | cut -d" " -f2)

# Instructions of a run: those of each block of code, as often as it ran. Debian builds the emulator without plugins.
rm -f "$root/tmp/blocks"
mkfifo "$root/tmp/blocks"
count() {
    awk "
        /^IN:/ { first = \"\"; inside = 1; next }
        inside && /^0x/ { at = substr(\$1, 3, length(\$1) - 3); if (first == \"\") { first = at; size[at] = 0 } size[first]++; next }
        inside && /^\$/ { inside = 0 }
        /^Trace/ { split(\$4, word, \"/\"); sub(/^0+/, \"\", word[2]); total += size[word[2]] }
        END { printf \"%d\n\", total }" "$root/tmp/blocks" &
    run qemu-aarch64 -L /usr/aarch64-linux-gnu -d in_asm,exec,nochain -D /tmp/blocks "$program" "$@" >/dev/null
    wait
}
echo "sampler,samples,steps,window_s,portable,neon,share"
while read -r sampler samples steps window_s; do
    for lanes in portable NEON; do
        twice=$(count $lanes $sampler $samples $steps $window_s 2)
        four_times=$(count $lanes $sampler $samples $steps $window_s 4)
        echo $(((four_times - twice) / 2))
    done | xargs | awk -v what="$sampler,$samples,$steps,$window_s" "{ printf \"%s,%d,%d,%.3f\n\", what, \$1, \$2, \$2 / \$1 }"
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
'

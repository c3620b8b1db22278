#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Compiles the measuring and motion code for this machine and for a Cortex-M4F, runs both (the latter under QEMU), and
# fails when a single bit of their results differs.
# check_same_bits.sh SOURCE_DIR GENERATED_DIR NANOPB_DIR WORK_DIR
set -euo pipefail

source_dir="$1" generated="$2" nanopb="$3" work="$4"
cross=arm-none-eabi
for tool in $cross-g++ qemu-system-arm; do
  command -v $tool >/dev/null || {
    echo "check_same_bits: skipped, $tool is missing; run script/setup, which installs it"
    exit 77
  }
done
mkdir -p "$work"
cd "$work"
compiler() { if command -v ccache >/dev/null; then ccache "$@"; else "$@"; fi; }

mapfile -t sources < <(find "$source_dir"/protocol/frame.cpp "$source_dir"/protocol/message.cpp "$source_dir"/protocol/beam_record.cpp "$source_dir"/protocol/encode_points.cpp \
  "$source_dir"/firmware/{measure,motion} "$source_dir"/firmware/machine_config.cpp "$source_dir"/firmware/arm_check/same_bits \
  -name '*.cpp' ! -name '*_test.cpp' | LC_ALL=C sort)
# build NAME COMPILER_PREFIX FLAGS...
build() {
  local name="$1" prefix="$2" objects=()
  shift 2
  local common=(-ffp-contract=off -fno-math-errno -ffunction-sections -fdata-sections -I"$source_dir" -isystem "$nanopb" -isystem "$generated")
  for file in "${sources[@]}"; do
    local object="$name-$(basename "$file").o"
    # As boards' images are: what every ray goes through for speed.
    local speed=()
    case "$file" in */firmware/measure/*) speed=(-O2) ;; esac
    compiler "${prefix}g++" -std=c++20 "${common[@]}" "$@" "${speed[@]}" -fno-exceptions -fno-rtti -fno-threadsafe-statics -Wall -Wextra -c "$file" -o "$object"
    objects+=("$object")
  done
  for file in "$nanopb"/pb_{common,encode,decode}.c "$generated"/protocol/machine.pb.c; do
    local object="$name-$(basename "$file").o"
    compiler "${prefix}gcc" "${common[@]}" "$@" -c "$file" -o "$object"
    objects+=("$object")
  done
  linked=("${objects[@]}")
}

build host "" -O2
g++ "${linked[@]}" -o same_bits-host
arm=(-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard -Os)
build arm $cross- "${arm[@]}"
$cross-gcc "${arm[@]}" -nostartfiles -nostdlib -Wl,--gc-sections -T "$source_dir/firmware/arm_check/same_bits/mps2_an386.ld" \
  "${linked[@]}" -lc_nano -lgcc -o same_bits-arm.elf
# Read to its end: with grep -q, nm may die of a closed pipe and pipefail would take that for nothing found.
initialised=$($cross-nm same_bits-arm.elf | grep ' [dD] ' || true)
if [ -n "$initialised" ]; then
  echo "check_same_bits: initialised data, which the start-up code does not copy: $initialised" >&2
  exit 1
fi

./same_bits-host >host.txt
timeout 900 qemu-system-arm -M mps2-an386 -nographic -monitor none -serial none \
  -semihosting-config enable=on,target=native -kernel same_bits-arm.elf >arm.txt 2>&1
cat arm.txt
if ! cmp -s host.txt arm.txt; then
  echo "check_same_bits: host and Cortex-M4F differ:" >&2
  diff host.txt arm.txt >&2 || true
  exit 1
fi
echo "check_same_bits: host and Cortex-M4F agree to the bit"

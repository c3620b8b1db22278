#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Compiles the firmware core for a Cortex-M4F as the boards do, links it without a heap, and fails when anything of a heap,
# of exceptions or of run-time type information got in.
# Prints what it takes of flash and memory, and the most stack along any chain of calls, and fails beyond the budget.
# check_arm.sh SOURCE_DIR GENERATED_DIR NANOPB_DIR WORK_DIR
set -euo pipefail

source_dir="$1" generated="$2" nanopb="$3" work="$4"
cross=arm-none-eabi
command -v $cross-g++ >/dev/null || {
  echo "check_arm: $cross-g++ is missing; run script/setup, which installs gcc-arm-none-eabi" >&2
  exit 1
}
mkdir -p "$work"
cd "$work"
rm -f ./*.ci

# -fno-math-errno: the square root is the processor's instruction alone.
common=(-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard -Os -ffunction-sections -fdata-sections
  -ffp-contract=off -fno-math-errno -fcallgraph-info=su -I"$source_dir" -isystem "$nanopb" -isystem "$generated")
cxx=("${common[@]}" -std=c++20 -fno-exceptions -fno-rtti -fno-threadsafe-statics -fno-unwind-tables
  -fno-asynchronous-unwind-tables -Wall -Wextra -Wconversion -Werror)

objects=()
while IFS= read -r file; do
  object="$(echo "${file#"$source_dir"/}" | tr / _).o"
  speed=()
  case "$file" in */firmware/measure/*) speed=(-O2) ;; esac
  $cross-g++ "${cxx[@]}" "${speed[@]}" -c "$file" -o "$object"
  objects+=("$object")
done < <(find "$source_dir/protocol" "$source_dir/firmware" -name '*.cpp' ! -name '*_test.cpp' ! -path '*/same_bits/*' | LC_ALL=C sort)
for file in "$nanopb"/pb_common.c "$nanopb"/pb_encode.c "$nanopb"/pb_decode.c "$generated"/protocol/machine.pb.c; do
  object="$(basename "$file").o"
  $cross-gcc "${common[@]}" -c "$file" -o "$object"
  objects+=("$object")
done

# -nostartfiles, and no libstdc++ at all: only the compiler's own helpers, and memcpy and friends of newlib.
$cross-gcc "${common[@]}" -nostartfiles -nostdlib -Wl,--gc-sections -Wl,-e,Reset_Handler \
  -Wl,-Ttext=0x08000000 -Wl,-Tdata=0x20000000 "${objects[@]}" -lc_nano -lgcc -o core.elf

$cross-nm -C core.elf >symbols.txt
if grep -E ' (malloc|free|calloc|realloc|_malloc_r|_free_r|_sbrk|operator new\(unsigned int\)|operator delete|__cxa_throw|__cxa_begin_catch|__gxx_personality|typeinfo for|_Unwind_|abort)' symbols.txt; then
  echo "check_arm: the symbols above must not be in the firmware" >&2
  exit 1
fi
$cross-size core.elf
# An STM32F405 has 1 MB of flash and 128 KB of memory; a board's image is held to less (boards/cortex_m4/check_image.py). The store is not part of it, a chip keeps it in flash.
read -r text data bss _ < <($cross-size core.elf | tail -1)
stack=6144
store=$((16#$($cross-nm -S core.elf | awk '/store/ && $3 ~ /[bB]/ {print $2}')))
memory=$((data + bss - store + stack))
echo "flash: $((text + data)) of 1048576 bytes; memory: $memory of 131072 bytes, $stack of them for the stack"
if ((text + data > 1048576 || memory > 131072)); then
  echo "check_arm: beyond the budget" >&2
  exit 1
fi
$cross-nm core.elf | awk '{print $NF}' >linked.txt
/usr/bin/python3 -B "$source_dir/firmware/arm_check/worst_stack.py" --most "$stack" linked.txt ./*.ci

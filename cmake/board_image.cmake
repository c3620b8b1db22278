# SPDX-License-Identifier: Apache-2.0
# tetragauge_board_image(BOARD INTERRUPTS "LOW .. / HIGH .."): a build for the host builds the board's image too, in its
# images/BOARD, so that tests can run it; and a test that it keeps to its budgets. Sets BOARD_image in the caller to the .elf,
# or to nothing when there is no compiler for it. INTERRUPTS: the handlers by priority, see boards/cortex_m4/check_image.py.
include(ExternalProject)

function(tetragauge_board_image board)
  cmake_parse_arguments(arg "" "INTERRUPTS" "" ${ARGN})
  set(${board}_image "" PARENT_SCOPE)
  find_program(ARM_COMPILER arm-none-eabi-g++)
  if(NOT ARM_COMPILER)
    message(STATUS "boards/${board}: no arm-none-eabi-g++, so no image; script/setup installs it")
    return()
  endif()
  set(folder ${PROJECT_BINARY_DIR}/images/${board})
  ExternalProject_Add(image_${board}
    SOURCE_DIR ${PROJECT_SOURCE_DIR} BINARY_DIR ${folder} PREFIX ${folder}/external
    CMAKE_ARGS -DCMAKE_TOOLCHAIN_FILE=${PROJECT_SOURCE_DIR}/cmake/arm_none_eabi.cmake -DTETRAGAUGE_BOARD=${board}
               -DCMAKE_BUILD_TYPE=Release
    BUILD_ALWAYS TRUE INSTALL_COMMAND "" BUILD_BYPRODUCTS ${folder}/tetragauge-${board}.elf)
  set(${board}_image ${folder}/tetragauge-${board}.elf PARENT_SCOPE)
  add_test(NAME ${board}.image_keeps_its_budgets
           COMMAND /usr/bin/python3 -B ${PROJECT_SOURCE_DIR}/boards/cortex_m4/check_image.py
                   ${folder}/tetragauge-${board}.elf --interrupts ${arg_INTERRUPTS})
  set_tests_properties(${board}.image_keeps_its_budgets PROPERTIES COST 100 TIMEOUT 120 LABELS module)
endfunction()

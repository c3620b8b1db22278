# SPDX-License-Identifier: Apache-2.0
# tetragauge_board_image(BOARD): a build for the host builds the board's image too, in its images/BOARD, so that tests can
# run it. Sets BOARD_image in the caller to the .elf, or to nothing when there is no compiler for it.
include(ExternalProject)

function(tetragauge_board_image board)
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
endfunction()

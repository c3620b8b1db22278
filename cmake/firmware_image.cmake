# SPDX-License-Identifier: Apache-2.0
# tetragauge_firmware_image(BOARD SOURCES...): the image BOARD flashes, tetragauge-BOARD.elf and .bin in the build's root, of
# the sources, the start-up code of boards/cortex_m4 and the firmware. Placed by image.ld beside the caller.
function(tetragauge_firmware_image board)
  set(image tetragauge-${board})
  add_executable(${image} ${ARGN} ${PROJECT_SOURCE_DIR}/boards/cortex_m4/startup.cpp)
  set_target_properties(${image} PROPERTIES SUFFIX .elf RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}
                        LINK_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/image.ld;${PROJECT_SOURCE_DIR}/boards/cortex_m4/sections.ld")
  tetragauge_own_flags(${image})
  # Only the compiler's own helpers, and memcpy and friends of newlib.
  target_link_libraries(${image} PRIVATE tetragauge_firmware -lc_nano -lgcc)
  target_link_options(${image} PRIVATE -nostartfiles -nostdlib -Wl,--gc-sections -Wl,--fatal-warnings
                      -Wl,-Map=${PROJECT_BINARY_DIR}/${image}.map -L${PROJECT_SOURCE_DIR}
                      -T${CMAKE_CURRENT_SOURCE_DIR}/image.ld)
  add_custom_command(TARGET ${image} POST_BUILD
                     COMMAND ${CMAKE_OBJCOPY} -O binary $<TARGET_FILE:${image}> ${PROJECT_BINARY_DIR}/${image}.bin VERBATIM)
endfunction()

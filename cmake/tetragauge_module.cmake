# SPDX-License-Identifier: Apache-2.0
# One module = one folder = one target. tetragauge_module(NAME DEPENDS targets... [TEST_DEPENDS targets...]
# [SUBFOLDERS folders...]) compiles every x.cpp of the folder (and of the subfolders named) into the library
# tetragauge_NAME and every x_test.cpp into one test program NAME_test. A folder without sources becomes a header-only
# library. Tests are built for the host alone.
if(NOT CMAKE_CROSSCOMPILING)
  include(GoogleTest)
endif()

function(tetragauge_own_flags target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Werror)
  # GCC 12 sees overlaps inside std::string that are not there (gcc bug 105329).
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
endfunction()

function(tetragauge_module name)
  cmake_parse_arguments(arg "" "" "DEPENDS;TEST_DEPENDS;SUBFOLDERS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  foreach(subfolder ${arg_SUBFOLDERS})
    file(GLOB more CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${subfolder}/*.cpp)
    list(APPEND sources ${more})
  endforeach()
  set(tests ${sources})
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")
  set(library tetragauge_${name})
  if(sources)
    add_library(${library} STATIC ${sources})
    target_include_directories(${library} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(${library} PUBLIC ${arg_DEPENDS})
    tetragauge_own_flags(${library})
  else()
    add_library(${library} INTERFACE)
    target_include_directories(${library} INTERFACE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${library} INTERFACE ${arg_DEPENDS})
  endif()
  if(tests AND NOT CMAKE_CROSSCOMPILING)
    add_executable(${name}_test ${tests})
    target_link_libraries(${name}_test PRIVATE ${library} ${arg_TEST_DEPENDS} GTest::gtest_main)
    tetragauge_own_flags(${name}_test)
    # COST puts the fast module tests before the end-to-end ones when ctest runs in parallel.
    gtest_discover_tests(${name}_test TEST_PREFIX "${name}." DISCOVERY_MODE PRE_TEST
                         PROPERTIES COST 100 TIMEOUT 300 LABELS module)
  endif()
endfunction()

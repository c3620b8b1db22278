# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -DNPM=npm -DFOLDER=DIR -P install.cmake    the packages of package-lock.json into DIR/node_modules
execute_process(COMMAND ${NPM} ci --ignore-scripts --loglevel=error --fetch-retry-mintimeout=1000 --fetch-retry-maxtimeout=5000
  WORKING_DIRECTORY ${FOLDER}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  file(WRITE ${FOLDER}/npm.log "${output}")
  message(FATAL_ERROR "The report page needs two packages from npm's registry (three, esbuild), and \"npm ci\" could not get them. "
    "Check the network or npm's proxy settings and build again; script/setup installs Node.js 18 and npm if they are not there. "
    "What npm said is in ${FOLDER}/npm.log")
endif()

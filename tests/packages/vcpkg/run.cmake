# Stands in for vcpkg, which is not available here: the functions that the port calls, after its
# documentation, in script mode. PORT is the port's folder, VERSION the version in its manifest. The
# installation goes to PACKAGES.
set(CURRENT_PORT_DIR "${PORT}")
set(CURRENT_PACKAGES_DIR "${PACKAGES}")

function(command)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(vcpkg_extract_source_archive variable)
  cmake_parse_arguments(given "" "ARCHIVE" "" ${ARGN})
  file(ARCHIVE_EXTRACT INPUT "${given_ARCHIVE}" DESTINATION "${PACKAGES}.src")
  file(GLOB found "${PACKAGES}.src/*") # the one folder inside
  set(${variable} "${found}" PARENT_SCOPE)
endfunction()

function(vcpkg_cmake_configure)
  cmake_parse_arguments(given "" "SOURCE_PATH" "OPTIONS" ${ARGN})
  foreach(type Release Debug)
    command("${CMAKE_COMMAND}" -S "${given_SOURCE_PATH}" -B "${PACKAGES}.${type}" -DCMAKE_BUILD_TYPE=${type}
            "-DCMAKE_INSTALL_PREFIX=${PACKAGES}${debug}" -DCMAKE_INSTALL_LIBDIR=lib ${given_OPTIONS})
    set(debug "/debug")
  endforeach()
endfunction()

function(vcpkg_cmake_install)
  command("${CMAKE_COMMAND}" --build "${PACKAGES}.Release" --target install)
  command("${CMAKE_COMMAND}" --build "${PACKAGES}.Debug" --target install)
endfunction()

function(vcpkg_cmake_config_fixup)
  cmake_parse_arguments(given "" "CONFIG_PATH" "" ${ARGN})
  foreach(at "${PACKAGES}" "${PACKAGES}/debug")
    if(NOT IS_DIRECTORY "${at}/${given_CONFIG_PATH}")
      message(FATAL_ERROR "no ${at}/${given_CONFIG_PATH}")
    endif()
  endforeach()
  file(MAKE_DIRECTORY "${PACKAGES}/share")
  file(RENAME "${PACKAGES}/${given_CONFIG_PATH}" "${PACKAGES}/share/davar")
  file(REMOVE_RECURSE "${PACKAGES}/debug/${given_CONFIG_PATH}")
endfunction()

function(vcpkg_fixup_pkgconfig)
endfunction()

function(vcpkg_install_copyright)
  cmake_parse_arguments(given "" "" "FILE_LIST" ${ARGN})
  file(COPY_FILE "${given_FILE_LIST}" "${PACKAGES}/share/davar/copyright")
endfunction()

include("${PORT}/portfile.cmake")

# Packages of Debian and a tarball (compiler/package/release makes all that a release has):
#   ninja -C build sightline sightline_documents sightline_reader_shared sightline_localizer_shared sightline_reader
#   (cd build && cpack)            # .deb; needs dpkg-dev
#   (cd build && cpack -G TGZ)     # sightline-VERSION-ARCHITECTURE.tar.gz
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sightline)
set(CPACK_PACKAGE_VENDOR "sightline")
set(SIGHTLINE_MAINTAINER "sightline developers <sightline@example.org>" CACHE STRING "Who answers for the packages")
set(CPACK_PACKAGE_CONTACT "${SIGHTLINE_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program reader reader_library localizer localizer_library python)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
# Programs that link the libraries find their packages by this.
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")

# sightline_debian(COMPONENT PACKAGE SECTION SUMMARY TEXT): with the licence and the changelog, as Debian wants them.
find_program(SIGHTLINE_GZIP gzip REQUIRED)
execute_process(COMMAND ${SIGHTLINE_GZIP} -9nc ${PROJECT_SOURCE_DIR}/compiler/package/changelog
  OUTPUT_FILE ${PROJECT_BINARY_DIR}/changelog.gz)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/compiler/package/changelog)
macro(sightline_debian component package section summary text)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}\n${text}")
  set(documents ${CMAKE_INSTALL_DATADIR}/doc/${package})
  install(FILES compiler/package/copyright ${PROJECT_BINARY_DIR}/changelog.gz
          DESTINATION ${documents} COMPONENT ${component})
endmacro()
set(same "(= ${PROJECT_VERSION})")

sightline_debian(program sightline science "compiler of maps with the LiDAR range that a vehicle needs"
  "From recorded LiDAR drives it makes an NDT map that carries, for every metre of
route, the shortest observation range that keeps the localization error within
a limit.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
install(FILES ${PROJECT_BINARY_DIR}/sightline.spdx.json
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/sightline COMPONENT program)

sightline_debian(reader_library libsightline-reader0 libs "reader of sightline maps for a vehicle's program"
  "Answers of a compiled map: how far to look at a place, and the cheapest way to
localize there. C interface; the standard library alone.")
set(CPACK_DEBIAN_READER_LIBRARY_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_READER_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/compiler/package/triggers)

sightline_debian(reader libsightline-reader-dev libdevel "what a vehicle's program is built with to read sightline maps"
  "Headers for C++ and C, the static library, the link of the shared one, and what
CMake and pkg-config need.")
set(CPACK_DEBIAN_READER_PACKAGE_DEPENDS "libsightline-reader0 ${same}, libstdc++-12-dev | libstdc++-dev")

sightline_debian(localizer_library libsightline-localizer0 libs "localizes LiDAR scans in a sightline map or a point cloud"
  "The matcher whose errors a compiled map predicts, for a vehicle's own program:
NDT on compiled maps or point clouds. C interface.")
set(CPACK_DEBIAN_LOCALIZER_LIBRARY_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LOCALIZER_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/compiler/package/triggers)

sightline_debian(localizer libsightline-localizer-dev libdevel "what a vehicle's program is built with to localize"
  "Headers for C++ and C, the link of the shared library, and what CMake and
pkg-config need.")
set(CPACK_DEBIAN_LOCALIZER_PACKAGE_DEPENDS "libsightline-localizer0 ${same}, libsightline-reader-dev ${same}")

sightline_debian(python python3-sightline python "maps of sightline and its localizer from Python"
  "How far a vehicle must look and where it is, with normal distributions and
sites as arrays of NumPy where that is installed.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.9), libsightline-reader0 (>= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "libsightline-localizer0 (>= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-numpy)

# One tarball with all components. What its program needs of Debian comes by its own install_runtime.
set(CPACK_ARCHIVE_COMPONENT_INSTALL OFF)
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/compiler/package/cpack_project.cmake)
set(CPACK_PACKAGE_FILE_NAME sightline-${PROJECT_VERSION}-${CMAKE_SYSTEM_PROCESSOR})
set(runtime_packages ${PROJECT_BINARY_DIR}/runtime_packages.txt)
add_custom_command(OUTPUT ${runtime_packages}
  COMMAND ${PROJECT_SOURCE_DIR}/compiler/package/write_runtime_packages $<TARGET_FILE:sightline> ${runtime_packages}
  DEPENDS sightline compiler/package/write_runtime_packages
  VERBATIM)
add_custom_target(sightline_runtime_packages DEPENDS ${runtime_packages})
add_dependencies(sightline_documents sightline_runtime_packages)
install(PROGRAMS examples/images/install_runtime DESTINATION ${CMAKE_INSTALL_DATADIR}/sightline COMPONENT program)
install(FILES ${runtime_packages} DESTINATION ${CMAKE_INSTALL_DATADIR}/sightline COMPONENT program)

# cpack packs what was built; building every test first would be another matter.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)
include(CPack)

# Debian packages: `ninja -C build sightline sightline_reader sightline_documents && (cd build &&
# cpack)`. One holds the program, one what a vehicle's program links. Needs dpkg-dev.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sightline)
set(CPACK_PACKAGE_VENDOR "sightline")
set(CPACK_PACKAGE_CONTACT "sightline developers <sightline@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program reader)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME sightline)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
  "compiler of maps that tell a vehicle how far it must look
From recorded LiDAR drives it makes an NDT map that carries, for every metre of
route, the shortest observation range that keeps the localization error within
a limit.")

set(CPACK_DEBIAN_READER_PACKAGE_NAME libsightline-reader-dev)
set(CPACK_DEBIAN_READER_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_READER_PACKAGE_DEPENDS "libstdc++-12-dev | libstdc++-dev")
set(CPACK_COMPONENT_READER_DESCRIPTION
  "what a vehicle's program links to read sightline maps
Headers, static libraries and CMake package of the map reader: C++ and C, the
standard library alone.")

# cpack packs what was built; building every test first would be another matter.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)
include(CPack)

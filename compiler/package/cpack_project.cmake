# What differs between the packages, read by cpack for each kind.
if(CPACK_GENERATOR STREQUAL "TGZ")
  set(CPACK_PACKAGING_INSTALL_PREFIX /)  # the folder that the tarball makes
endif()

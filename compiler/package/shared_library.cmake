# What a vehicle's program links at run time, and how it finds it.

# sightline_shared_library(TARGET NAME): libNAME.so.0, which shows its C interface alone.
function(sightline_shared_library target name)
  set_target_properties(${target} PROPERTIES
    OUTPUT_NAME ${name} VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR} LINKER_LANGUAGE CXX
    LINK_DEPENDS ${PROJECT_SOURCE_DIR}/compiler/package/c_interface.map)
  # What a sanitizer needs lies in the program, not in what a library links.
  target_link_options(${target} PRIVATE
    -Wl,--version-script=${PROJECT_SOURCE_DIR}/compiler/package/c_interface.map
    -Wl,--as-needed -Wl,--gc-sections $<$<NOT:$<BOOL:${SIGHTLINE_SANITIZER}>>:-Wl,-z,defs>)
  # Also in a program of C, whose linker does not think of C++ itself.
  if(SIGHTLINE_SANITIZER STREQUAL "address")
    target_link_options(${target} INTERFACE $<BUILD_INTERFACE:-fsanitize=address,undefined>
      $<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:Clang>:-fsanitize-link-c++-runtime>>)
    target_link_libraries(${target} INTERFACE $<BUILD_INTERFACE:stdc++>)
  elseif(SIGHTLINE_SANITIZER)
    target_link_options(${target} INTERFACE $<BUILD_INTERFACE:-fsanitize=${SIGHTLINE_SANITIZER}>)
  endif()
endfunction()

# Installs the library, and what programs are built with, for find_package(sightline). A set of targets of its own: where
# the library is not installed, find_package goes without it.
function(sightline_install_shared target)
  cmake_parse_arguments(ARG "" "LIBRARY_COMPONENT;DEVELOPMENT_COMPONENT" "" ${ARGN})
  install(TARGETS ${target} EXPORT ${target}Targets
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
          COMPONENT ${ARG_LIBRARY_COMPONENT} NAMELINK_COMPONENT ${ARG_DEVELOPMENT_COMPONENT})
  install(EXPORT ${target}Targets NAMESPACE sightline:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sightline
          COMPONENT ${ARG_DEVELOPMENT_COMPONENT})
endfunction()

# A file for pkg-config that does not name where it was installed.
function(sightline_install_pkgconfig name title description component)
  file(RELATIVE_PATH SIGHTLINE_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  set(SIGHTLINE_PC_NAME ${name})
  set(SIGHTLINE_PC_TITLE ${title})
  set(SIGHTLINE_PC_DESCRIPTION ${description})
  configure_file(${PROJECT_SOURCE_DIR}/compiler/package/library.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
          COMPONENT ${component})
endfunction()

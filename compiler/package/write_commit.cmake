# Writes the commit of SOURCE into the header OUTPUT; "unknown" where that is no checkout, and with a warning where Git
# does not read it. Run by every build, and writes only what changed.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND git -C ${SOURCE} rev-parse --short=12 HEAD
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_VARIABLE reason RESULT_VARIABLE failed)
if(failed)
  set(commit unknown)
  if(EXISTS ${SOURCE}/.git)
    string(STRIP "${reason}" reason)
    message(WARNING "the program will name its commit as unknown, since Git does not read ${SOURCE}: ${reason}")
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define SIGHTLINE_COMMIT \"${commit}\"\n" @ONLY)

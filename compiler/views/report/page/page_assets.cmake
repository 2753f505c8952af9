# Writes texts into a C++ file as raw strings. GCC and Clang take literals of any length.
function(literal variable file)
  file(READ ${file} text)
  string(FIND "${text}" ")~page~\"" end)
  if(NOT end EQUAL -1)
    message(FATAL_ERROR "${file} holds the end of a raw string")
  endif()
  set(${variable} "R\"~page~(${text})~page~\"" PARENT_SCOPE)
endfunction()

literal(style ${STYLE})
literal(library_style ${LIBRARY_STYLE})
literal(script ${SCRIPT})
literal(scene ${SCENE})
file(WRITE ${OUTPUT} "#include \"compiler/views/report/page/page_assets.h\"

namespace sightline {

std::string_view page_style() { return ${style}; }
std::string_view library_style() { return ${library_style}; }
std::string_view page_script() { return ${script}; }
std::string_view scene_script() { return ${scene}; }

}  // namespace sightline
")
